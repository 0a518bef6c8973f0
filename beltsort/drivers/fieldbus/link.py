"""One connection to a controller, and how a request crosses it."""

import time
from importlib.util import find_spec
from typing import NamedTuple, Protocol

from beltsort.drivers.fieldbus.wire import GarbageError, Reply, Request, Verb, following, is_ahead
from beltsort.errors import CellError

ACKNOWLEDGE_POLL = 0.002
"""Seconds between two looks for an acknowledgement."""


class Link(Protocol):
    """A connection. Its methods raise whatever its driver raises, and it is then never used again."""

    def write(self, request: Request) -> None:
        """Write a request, all of it at once."""

    def read(self) -> Reply:
        """Read the latest reply, all of it at once. Raises `GarbageError` if it is none."""

    def close(self) -> None:
        """Give the connection up without waiting for the other side."""


class LinkError(CellError):
    """The controller did not answer as the protocol says."""


class Order(NamedTuple):
    """A request without its number."""

    verb: Verb
    target: int = 0
    key: int = 0


class Conversation:
    """Numbers requests and waits for their replies.

    It goes on behind the last number that was answered or sent, and leaves one out: the request of that
    number may have acted unanswered. What an earlier connection still delivers is then behind, and ignored,
    as soon as anything here was answered.

    Parameters
    ----------
    link
        Over which they go.
    sent
        The last number that this program sent over an earlier connection, if any.

    Attributes
    ----------
    sequence
        The last number sent.
    """

    def __init__(self, link: Link, sent: int | None) -> None:
        answered = _answered(link)
        self._link = link
        self.sequence = following(sent if sent is not None and is_ahead(sent, of=answered) else answered)

    def ask(self, order: Order, seconds: float) -> Reply:
        """Write a request and return its reply.

        Raises
        ------
        LinkError
            If the controller acknowledges nothing within `seconds`, or somebody else's request.
        """
        end = time.monotonic() + seconds
        self.sequence = following(self.sequence)
        self._link.write(Request(self.sequence, *order))
        while (reply := self._reply()) is None:
            if time.monotonic() > end:
                raise LinkError(
                    f"the controller acknowledged request {_answered(self._link)}, expected {self.sequence} "
                    f"within {seconds:g} s; see whether its program runs, and whether another one commands it"
                )
            time.sleep(ACKNOWLEDGE_POLL)
        if (reply.verb, reply.key) != (order.verb, order.key):
            raise LinkError(
                f"request {self.sequence} was answered as verb {reply.verb} for key {reply.key}, expected "
                f"{int(order.verb)} for {order.key}; let only one program command a controller"
            )
        return reply

    def close(self) -> None:
        """Give the connection up."""
        self._link.close()

    def _reply(self) -> Reply | None:
        """Return the reply to the last request, or None while an earlier one stands there, garbage or not."""
        try:
            reply = self._link.read()
        except GarbageError as garbage:
            if garbage.sequence == self.sequence:
                raise
            return None
        return reply if reply.sequence == self.sequence else None


def _answered(link: Link) -> int:
    """Return the sequence of the latest reply. The rest may be garbage from before the controller ran."""
    try:
        return link.read().sequence
    except GarbageError as garbage:
        return garbage.sequence


def require(package: str, extra: str) -> None:
    """Refuse to go on without an optional package.

    Raises
    ------
    CellError
        That says how to install it.
    """
    if find_spec(package) is None:
        raise CellError(
            f"{package} is not installed, expected it for this device; pip install 'beltsort[{extra}]'"
        )
