"""`python -m beltsort`."""

import sys

from beltsort.cli import main

sys.exit(main())
