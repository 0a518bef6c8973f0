"""A link to a controller that reconnects after a failure or a timeout."""

import logging
import time
from collections.abc import Callable
from contextlib import suppress
from threading import Lock
from typing import Generic, TypeAlias

from beltsort.cell.commands import CommandError, Outcome, within
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.fieldbus.link import Conversation, Link, ReplyT, RequestT

log = logging.getLogger(__name__)

Connect: TypeAlias = Callable[[float], Link[RequestT, ReplyT]]
"""Opens a connection; the argument is the timeout of each call of the fieldbus library, seconds."""


HANDSHAKE = 5.0
"""Timeout of connecting as a multiple of that of a reply, since it exchanges several messages."""

LAST_ATTEMPT = 1e-3
"""Timeout of what is tried at the deadline, seconds, so that it may still succeed."""


class ReconnectingLink(Generic[RequestT, ReplyT]):
    """Sends requests over one connection at a time. Thread-safe.

    A connection that failed or timed out is closed; the next request opens a new one.

    Parameters
    ----------
    connect
        Opens a connection.
    answer_timeout
        Timeout of the acknowledgement of a request, seconds.
    name
        Name of the other end in the log.
    """

    def __init__(
        self, connect: Connect[RequestT, ReplyT], answer_timeout: float, name: str = "the controller"
    ) -> None:
        self._connect = connect
        self._answer_timeout, self._name = answer_timeout, name
        self._lock = Lock()
        self._conversation: Conversation[RequestT, ReplyT] | None = None
        self._sent: int | None = None

    def send_repeatable(self, request: RequestT, deadline: Deadline) -> ReplyT:
        """Send a request that may be repeated; if an open connection fails, retry over a new one."""
        if self._conversation is not None:
            with suppress(Exception):  # any exception; the new connection raises its own
                return self.send(request, deadline)
        return self.send(request, deadline)

    def send(self, request: RequestT, deadline: Deadline) -> ReplyT:
        """Send a request once, over the open connection or a new one; raises the library's exceptions."""
        if not self._lock.acquire(timeout=_left(deadline)):
            raise TimeoutError(
                f"another thread's request took longer than {deadline.timeout:g} s; retry, or give a longer "
                "timeout"
            )
        try:
            if self._conversation is None:
                self._conversation = self._connected(min(HANDSHAKE * self._answer_timeout, _left(deadline)))
                log.info("connected to %s", self._name)
            conversation = self._conversation
            seconds = min(self._answer_timeout, _left(deadline))
            return within(seconds, "the answer", lambda: conversation.ask(request, seconds))
        except BaseException as failure:
            if self._conversation is not None:
                log.warning("lost the connection to %s (%r); the next request opens one", self._name, failure)
            self._close_connection()
            raise
        finally:
            self._lock.release()

    def close(self) -> None:
        """Close the connection."""
        with self._lock:
            self._close_connection()

    def _connected(self, seconds: float) -> Conversation[RequestT, ReplyT]:
        """Open a connection; one that is established after the timeout is closed."""
        end = time.monotonic() + seconds

        def connect() -> Conversation[RequestT, ReplyT]:
            link = self._connect(seconds)
            try:
                conversation = Conversation(link, self._sent)
            except BaseException:
                link.close()
                raise
            if time.monotonic() > end:
                link.close()
            return conversation

        return within(seconds, "connecting", connect)

    def _close_connection(self) -> None:
        if self._conversation is not None:
            self._sent = self._conversation.sequence
            self._conversation.close()
            self._conversation = None


def unanswered(what: str, name: str, failure: Exception, outcome: Outcome) -> CommandError:
    """Return the error of a request to which there is no reply.

    Parameters
    ----------
    what
        What was asked for.
    name
        Name of the controller.
    failure
        Why there is no reply.
    outcome
        What is known about the command.
    """
    return CommandError(
        f"{what}: {name} cannot be asked ({type(failure).__name__}: {failure}); check that it runs, its "
        "address and certificates",
        outcome,
    )


def _left(deadline: Deadline) -> float:
    return max(LAST_ATTEMPT, deadline.left())
