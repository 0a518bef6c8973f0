"""The record of a run's device calls: files of bounded size, the newest without a number."""

import json
from dataclasses import asdict
from pathlib import Path

from beltsort.cell.wrappers.recorder import Recorded
from beltsort.errors import JournalNotWrittenError

CALLS = "calls.jsonl"
LARGEST, KEEP = 20_000_000, 4
"""Size at which a file is full, bytes; number of full files that are kept."""


class CallLog:
    """Adds calls of devices, a line of JSON each, to a file in the run's folder.

    A full file gets the number 1 (`calls.jsonl.1`), those before it the next numbers, and the oldest is
    dropped.

    Parameters
    ----------
    folder
        The run's.
    largest, keep
        As `LARGEST` and `KEEP`.

    Attributes
    ----------
    folder
        Must exist when the first call is recorded.
    """

    def __init__(self, folder: Path, *, largest: int = LARGEST, keep: int = KEEP) -> None:
        self.folder = folder
        self._largest, self._keep = largest, keep

    def __call__(self, recorded: Recorded) -> None:
        """Add one call; its line is there as a whole, or not at all.

        Raises
        ------
        JournalNotWrittenError
            If it cannot be written.
        """
        path, line = self.folder / CALLS, f"{json.dumps(asdict(recorded))}\n".encode()
        try:
            self._make_room(path, len(line))
            _append(path, line)
        except OSError as reason:
            raise JournalNotWrittenError(
                f"the record of calls {path} cannot be written: {reason}; check that its folder exists and "
                "is writable and that the disk is not full"
            ) from reason

    def _make_room(self, path: Path, size: int) -> None:
        """Begin a new file if the present one has no room for `size` bytes."""
        if not path.exists() or path.stat().st_size + size <= self._largest:
            return
        for number in range(self._keep, 0, -1):
            older = path if number == 1 else path.with_name(f"{CALLS}.{number - 1}")
            if older.exists():
                older.replace(path.with_name(f"{CALLS}.{number}"))


def _append(path: Path, line: bytes) -> None:
    """Append a line to a file, unbuffered; if the disk takes a part of it, that is removed."""
    with path.open("ab", buffering=0) as file:
        size = file.tell()
        try:
            written = file.write(line)
            if written < len(line):
                raise OSError(f"the disk took {written} of {len(line)} bytes")
        except OSError:
            file.truncate(size)
            raise


def calls_in(folder: Path) -> list[Path]:
    """Return the files of a run's device calls, oldest first."""
    full = sorted(folder.glob(f"{CALLS}.[0-9]*"), key=lambda file: -int(file.suffix[1:]))
    return [*full, *([folder / CALLS] if (folder / CALLS).exists() else [])]
