"""The log file of a run: bounded, in UTC, as text or JSON lines."""

import json
import logging
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from logging.handlers import RotatingFileHandler
from pathlib import Path
from types import TracebackType
from typing import Literal, Self, TypeAlias

from beltsort._core import BeltsortError
from beltsort.errors import JournalError
from beltsort.monitoring.entry_logger import EntryLogger
from beltsort.sorting.journal import Entry

Format: TypeAlias = Literal["text", "json"]
Level: TypeAlias = Literal["debug", "info", "warning", "error"]
PACKAGE = "beltsort"
LARGEST, KEEP = 10_000_000, 9
"""Size at which a file is full, bytes; number of full files that are kept."""
PLACE = ("run", "step", "object")
"""Where a run is, in every record."""

log = logging.getLogger(__name__)


class LogFile:
    """Writes what the package logs to a file, and the entries of the journal, of which it is a listener.

    A full file gets the number 1 (`run.log.1`), those before it the next numbers. That a file can no longer
    be written is told once; each record is tried again, and the run goes on.

    Parameters
    ----------
    path
        The file, to which is added.
    say
        Called with a line if it can no longer be written.
    format
        "text" or "json", an object in each line.
    level
        The lowest level that is written.
    largest, keep
        As `LARGEST` and `KEEP`.

    Raises
    ------
    JournalError
        If the file cannot be written at the start.
    """

    def __init__(
        self,
        path: Path,
        say: Callable[[str], None],
        *,
        format: Format = "text",
        level: Level = "info",
        largest: int = LARGEST,
        keep: int = KEEP,
    ) -> None:
        self.entries = EntryLogger()
        try:
            self._handler = _Handler(path, say, largest, keep)
        except OSError as reason:
            raise JournalError(
                f"the log {path} cannot be written: {reason}; name a file in a folder that can be written"
            ) from reason
        self._handler.setLevel(level.upper())
        self._handler.addFilter(self._placed)
        self._handler.setFormatter(_JsonFormatter() if format == "json" else _TextFormatter())
        self._package = logging.getLogger(PACKAGE)
        self._level_before = self._package.level

    def __call__(self, entry: Entry) -> None:
        """Log an entry of the journal."""
        self.entries(entry)

    def __enter__(self) -> Self:
        """Begin to write what the package logs."""
        before = self._package.getEffectiveLevel()
        self._package.setLevel(min(before, self._handler.level))
        self._package.addHandler(self._handler)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file; an error that is not foreseen is written with its traceback."""
        if isinstance(error, Exception) and not isinstance(error, BeltsortError):
            log.critical("ended by an error that is not foreseen", exc_info=error)
        self._package.removeHandler(self._handler)
        self._package.setLevel(self._level_before)
        with suppress(OSError):  # all records have been written or told
            self._handler.close()

    def _placed(self, record: logging.LogRecord) -> bool:
        """Add to a record where the run is."""
        for name in PLACE:
            setattr(record, name, getattr(self.entries, name))
        return True


class _Handler(RotatingFileHandler):
    def __init__(self, path: Path, say: Callable[[str], None], largest: int, keep: int) -> None:
        super().__init__(
            path, maxBytes=largest, backupCount=keep, encoding="utf-8", errors="backslashreplace"
        )
        self._path, self._say, self._told = path, say, False

    def handleError(self, _record: logging.LogRecord) -> None:  # noqa: N802 (logging's name)
        """Say once that the log cannot be written; the next record opens the file again."""
        stream, self.stream = self.stream, None
        if stream is not None:
            with suppress(OSError):  # it may try to write once more
                stream.close()
        if not self._told:
            self._told = True
            self._say(f"the log {self._path} cannot be written; the run goes on, and lines are missing there")


class _JsonFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        """Return a record as one line of JSON."""
        fields: dict[str, object] = {
            "time": _time(record),
            "level": record.levelname.lower(),
            "logger": record.name,
            **{name: getattr(record, name, None) for name in (*PLACE, "kind", "entry")},
            "message": record.getMessage(),
        }
        if record.exc_info:
            fields["exception"] = self.formatException(record.exc_info)
        return json.dumps({name: value for name, value in fields.items() if value is not None})


class _TextFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        """Return a record as one line; a traceback follows on lines of its own."""
        place = (f"{name}={getattr(record, name)}" for name in PLACE if getattr(record, name) is not None)
        message = " ".join(record.getMessage().split())
        line = " ".join([_time(record), f"{record.levelname:<7}", *place, f"{record.name}: {message}"])
        return f"{line}\n{self.formatException(record.exc_info)}" if record.exc_info else line


def _time(record: logging.LogRecord) -> str:
    """Return the time of a record in UTC, ISO 8601, milliseconds."""
    when = datetime.fromtimestamp(record.created, UTC)
    return f"{when:%Y-%m-%dT%H:%M:%S}.{when.microsecond // 1000:03}Z"
