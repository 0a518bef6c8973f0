"""The line to a controller: one connection at a time, and a new one when it fails or hangs."""

import time
from collections.abc import Callable
from contextlib import suppress
from math import isfinite
from threading import Lock
from typing import TypeAlias

from beltsort.cell.commands import CommandError, Outcome, within
from beltsort.drivers.fieldbus.link import Conversation, Link, Order
from beltsort.drivers.fieldbus.wire import Reply

Connect: TypeAlias = Callable[[float], Link]
"""Builds a new connection; its argument is how many seconds each call of the driver may take."""


HANDSHAKE = 5.0
"""How much longer connecting may take than an answer: it exchanges several messages, and certificates."""


class Deadline:
    """Seconds that are left of a timeout."""

    def __init__(self, timeout: float) -> None:
        if not (isfinite(timeout) and timeout > 0.0):
            raise CommandError(
                f"timeout is {timeout}, expected seconds above 0; give a number", Outcome.NOT_DONE
            )
        self.timeout = timeout
        self._end = time.monotonic() + timeout

    @property
    def left(self) -> float:
        """Seconds until the deadline, never 0: what is tried at the last moment may still succeed."""
        return max(1e-3, self._end - time.monotonic())

    @property
    def over(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() >= self._end


class Line:
    """Sends orders over one connection at a time, from any thread.

    A connection that failed or hung is never used again.

    Parameters
    ----------
    connect
        Builds a connection.
    answer_timeout
        Seconds that the controller may take to acknowledge a request.
    """

    def __init__(self, connect: Connect, answer_timeout: float) -> None:
        self._connect = connect
        self._answer_timeout = answer_timeout
        self._lock = Lock()
        self._conversation: Conversation | None = None
        self._sent: int | None = None

    def insist(self, order: Order, deadline: Deadline) -> Reply:
        """Send what may be sent twice; if an old connection fails, once more over a new one."""
        if self._conversation is not None:
            with suppress(Exception):  # whatever the driver raises, the new connection tells
                return self.send(order, deadline)
        return self.send(order, deadline)

    def send(self, order: Order, deadline: Deadline) -> Reply:
        """Send an order once, over the connection at hand or a new one; raises whatever the driver raises."""
        if not self._lock.acquire(timeout=deadline.left):
            raise TimeoutError("another thread's request takes too long")
        try:
            if self._conversation is None:
                self._conversation = self._connected(min(HANDSHAKE * self._answer_timeout, deadline.left))
            conversation = self._conversation
            seconds = min(self._answer_timeout, deadline.left)
            return within(seconds, "the answer", lambda: conversation.ask(order, seconds))
        except BaseException:
            self._hang_up()
            raise
        finally:
            self._lock.release()

    def close(self) -> None:
        """Give the connection up."""
        with self._lock:
            self._hang_up()

    def _connected(self, seconds: float) -> Conversation:
        """Build a new connection; one that comes late is closed at once."""
        end = time.monotonic() + seconds

        def dial() -> Conversation:
            link = self._connect(seconds)
            try:
                conversation = Conversation(link, self._sent)
            except BaseException:
                link.close()
                raise
            if time.monotonic() > end:
                link.close()
            return conversation

        return within(seconds, "connecting", dial)

    def _hang_up(self) -> None:
        if self._conversation is not None:
            self._sent = self._conversation.sequence
            self._conversation.close()
            self._conversation = None
