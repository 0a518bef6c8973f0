"""A console for runs, which must continue after the reader of their output has closed the pipe."""

import os
import sys
from collections.abc import Mapping
from contextlib import suppress
from typing import IO, Any

from rich.console import Console

from beltsort.cli.output import print_json, print_status


class RunConsole(Console):
    """A console without markup that becomes silent on a broken pipe, where rich would exit.

    Text in square brackets, `[faults]` for example, is printed as it is.

    Attributes
    ----------
    closed
        Whether the reader has closed the pipe.
    """

    closed = False

    def __init__(self, *, stderr: bool) -> None:
        super().__init__(stderr=stderr, highlight=False, markup=False, soft_wrap=True)

    def on_broken_pipe(self) -> None:
        """Discard all further output."""
        self.closed = self.quiet = True
        discard(self.file)


def discard(stream: IO[str]) -> None:
    """Redirect a stream whose reader has closed the pipe to the null device."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream.fileno())
    os.close(null)
    with suppress(OSError):  # standard error may be closed as well
        print_status("beltsort: standard output was closed; further output is discarded")


def print_last_json(result: Mapping[str, Any]) -> None:
    """Print one JSON object as the last output; nothing if the reader has closed the pipe."""
    try:
        print_json(result)
        sys.stdout.flush()
    except BrokenPipeError:
        discard(sys.stdout)
