"""`import beltsort` brings no heavy package along; how long it takes is in benchmarks/test_import.py."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.process

SCRIPT = """
import sys
import beltsort
heavy = {"open3d", "matplotlib", "rich", "sklearn", "pydantic", "pyarrow", "distributed"}
print(*sorted(heavy & set(sys.modules)))
"""


def test_import() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
