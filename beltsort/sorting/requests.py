"""Requests of a person to hold a run between two steps, and to continue it.

A request is a file in the run's folder, of which there is at most one: what is wanted now. The loop reads it
between two steps, never inside a command, so that a crash of either side in between does no harm: a request
that was written stands, also for the run when it is resumed, until another replaces it.

Whoever makes requests over a network needs the run's token, a file that only the user of the run can read.
This is no safety function: an emergency stop is a matter of hardware.
"""

import getpass
import hmac
import json
import os
import platform
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from beltsort.errors import JournalError

REQUEST, TOKEN = "request.json", "request-token"

Action = Literal["hold", "continue"]


@dataclass(frozen=True)
class Request:
    """What a person wants of a run.

    Attributes
    ----------
    action
        `hold` or `continue`.
    by
        Who wants it.
    at
        Since when, UTC, ISO 8601.
    """

    action: Action
    by: str
    at: str

    @classmethod
    def now(cls, action: Action, through: str) -> "Request":
        """Return a request of this process's user, made now; `through` names the program."""
        by = f"{getpass.getuser()}@{platform.node()} ({through})"
        return cls(action, by, datetime.now(UTC).isoformat(timespec="seconds"))


def write_request(folder: Path, request: Request) -> None:
    """Leave a request in a run's folder; it is on the disk when this returns.

    Raises
    ------
    OSError
        If it cannot be written; an earlier request then still stands.
    """
    _replace(folder / REQUEST, json.dumps(asdict(request)))


def read_request(folder: Path) -> Request | None:
    """Return the request that stands; None if there is none, or the file is damaged."""
    try:
        fields = json.loads((folder / REQUEST).read_text("utf-8"))
        request = Request(**fields)
    except (OSError, ValueError, TypeError):
        return None
    return request if request.action in ("hold", "continue") else None


def standing_hold(folder: Path) -> Request | None:
    """Return the request to hold a run; None unless one stands."""
    request = read_request(folder)
    return request if request is not None and request.action == "hold" else None


def takes_requests(folder: Path) -> bool:
    """Whether a run has a token, as one that takes requests has while it lasts."""
    return (folder / TOKEN).exists()


def read_token(folder: Path) -> str | None:
    """Return the token of a run; None if it takes no requests, or this user may not read it."""
    try:
        return (folder / TOKEN).read_text("ascii") or None
    except (OSError, ValueError):
        return None


def is_token(folder: Path, given: str) -> bool:
    """Whether a token is that of a run, in a time that does not depend on how much of it is right."""
    token = read_token(folder)
    return token is not None and hmac.compare_digest(token.encode(), given.encode())


@contextmanager
def taking_requests(folder: Path) -> Iterator[None]:
    """Let a run take requests as long as the block runs: make a new token, which is removed afterwards.

    Raises
    ------
    JournalError
        If the token cannot be written.
    """
    try:
        _replace(folder / TOKEN, secrets.token_urlsafe(32))
    except OSError as reason:
        raise JournalError(
            f"{folder / TOKEN} cannot be written: {reason}; run without --allow-hold, or make room"
        ) from reason
    try:
        yield
    finally:
        (folder / TOKEN).unlink(missing_ok=True)


def drop_requests(folder: Path) -> None:
    """Remove what requests an earlier process has left, for a run that takes none."""
    for name in (REQUEST, TOKEN):
        (folder / name).unlink(missing_ok=True)


def _replace(path: Path, text: str) -> None:
    """Write a file that only this user can read, durably and at once."""
    fresh = path.with_name(f"{path.name}.new-{os.getpid()}")
    try:
        descriptor = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        with os.fdopen(descriptor, "w") as file:
            os.fchmod(descriptor, 0o600)  # also if a crash has left it there
            file.write(text)
            file.flush()
            os.fsync(descriptor)
        fresh.replace(path)
    except OSError:
        fresh.unlink(missing_ok=True)
        raise
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
