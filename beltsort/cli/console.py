"""A console for what goes on although nobody reads any more."""

import os
import sys
from contextlib import suppress

from rich.console import Console

from beltsort.cli.output import tell


class LastingConsole(Console):
    """Prints nothing more once its reader has gone, where rich would end the program.

    Attributes
    ----------
    gone
        Whether the reader has gone.
    """

    gone = False

    def on_broken_pipe(self) -> None:
        """Print nothing more."""
        self.gone = self.quiet = True
        discard_output()


def discard_output() -> None:
    """Send standard output to nowhere, from now on, as whoever read it has gone."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
    with suppress(OSError):  # standard error may be gone as well
        tell("beltsort: standard output was closed; nothing more is printed there")
