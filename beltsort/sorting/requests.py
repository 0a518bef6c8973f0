"""Requests of a person to hold, continue or stop a run between two steps, and answers to its questions.

A request is a file in the run's folder, of which there is at most one: what is wanted now. The loop reads it
between two steps, never inside a command, so that a crash of either side in between does no harm: a request
to hold stands, also for the run when it is resumed, until another replaces it. An answer is a
second file, which names the question that it is for.

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
from typing import Literal, get_args

from beltsort.errors import JournalError
from beltsort.sorting.holds import Answer, HeldError, Reply

REQUEST, ANSWER, TOKEN = "request.json", "answer.json", "request-token"

Action = Literal["hold", "continue", "stop"]


@dataclass(frozen=True)
class Request:
    """What a person wants of a run.

    Attributes
    ----------
    action
        `hold`, `continue` or `stop`.
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
        return cls(action, *signature(through))


def signature(through: str) -> tuple[str, str]:
    """Return who asks or answers, and when: this process's user, now; `through` names the program."""
    by = f"{getpass.getuser()}@{platform.node()} ({through})"
    return by, datetime.now(UTC).isoformat(timespec="seconds")


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
    return request if request.action in get_args(Action) else None


def standing_hold(folder: Path) -> Request | None:
    """Return the request to hold a run; None unless one stands."""
    request = read_request(folder)
    return request if request is not None and request.action == "hold" else None


def write_reply(folder: Path, reply: Reply, question: int) -> None:
    """Leave the answer to a question for a run that waits for it; it is on the disk when this returns.

    Parameters
    ----------
    folder
        The run's.
    reply
        The answer.
    question
        Number of the journal entry that asks.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    _replace(folder / ANSWER, json.dumps({"question": question, **asdict(reply)}))


def read_reply(folder: Path, question: int | None) -> Reply | None:
    """Return the answer to a question; None if there is none, or the file is damaged."""
    try:
        fields = json.loads((folder / ANSWER).read_text("utf-8"))
        if question is None or fields.pop("question") != question:
            return None
        return Reply(Answer(fields.pop("answer")), **fields)
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None


def takes_requests(folder: Path) -> bool:
    """Whether a run has a token, as one that takes requests has while it lasts or a question is open."""
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

    An earlier request to stop is dropped: it was for the process that has ended. If the run ends with a
    question, the token stays, so that the question can be answered with it.

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
    (folder / ANSWER).unlink(missing_ok=True)
    standing = read_request(folder)
    if standing is not None and standing.action == "stop":
        drop_request(folder)
    question = False
    try:
        yield
    except HeldError as held:
        question = bool(held.hold.answers)
        raise
    finally:
        if not question:
            (folder / TOKEN).unlink(missing_ok=True)


def drop_request(folder: Path) -> None:
    """Remove the request that stands, if there is one."""
    (folder / REQUEST).unlink(missing_ok=True)


def drop_requests(folder: Path) -> None:
    """Remove what requests an earlier process has left, for a run that takes none."""
    for name in (REQUEST, ANSWER, TOKEN):
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
