"""A console for what goes on although nobody reads any more."""

import os
from contextlib import suppress
from typing import IO

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
        discard(self.file)


def discard(stream: IO[str]) -> None:
    """Send a stream to nowhere from now on, as whoever read it has gone; the other stream stays."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
    with suppress(OSError):  # standard error may be gone as well
        tell("beltsort: standard output was closed; nothing more is printed there")
