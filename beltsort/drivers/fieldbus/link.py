"""One connection to a controller, and the exchange of requests and replies over it."""

import time
from typing import Generic, Protocol, Self, TypeVar

from beltsort.drivers.fieldbus.wire import GarbageError, following, is_ahead
from beltsort.errors import CellError

ACKNOWLEDGE_POLL = 0.002
"""Interval at which an acknowledgement is polled, seconds."""


class Message(Protocol):
    """What requests and replies have in common."""

    @property
    def sequence(self) -> int:
        """The sequence number."""

    @property
    def verb(self) -> int:
        """The operation that the request asks for."""

    @property
    def key(self) -> int:
        """The key of the command that it is about; 0 for none."""


class NumberedRequest(Message, Protocol):
    """A request, which gets its sequence number when it is sent."""

    def numbered(self, sequence: int) -> Self:
        """Return the same request with a sequence number."""


RequestT = TypeVar("RequestT", bound=NumberedRequest)
ReplyT = TypeVar("ReplyT", bound=Message)
Written = TypeVar("Written", bound=NumberedRequest, contravariant=True)
Read = TypeVar("Read", bound=Message, covariant=True)


class Link(Protocol[Written, Read]):
    """A connection, unusable after any exception of the fieldbus library, which its methods raise."""

    def write(self, request: Written) -> None:
        """Write a request atomically."""

    def read(self) -> Read:
        """Read the latest reply atomically.

        Raises
        ------
        GarbageError
            If it is invalid.
        MissingPartError
            If the controller does not have it.
        """

    def close(self) -> None:
        """Close the connection without waiting for the other side."""


class LinkError(CellError):
    """The controller did not answer as the protocol says."""


class MissingPartError(LinkError):
    """The controller does not have the nodes or registers that a link uses."""


class Conversation(Generic[RequestT, ReplyT]):
    """Assigns sequence numbers to requests and waits for their replies.

    Numbering continues after the last number that was answered or sent, skipping one, since the request with
    that number may have been executed without a reply. Once a request has been answered, requests that an
    earlier connection delivers late are out of date, and the controller ignores them.

    Parameters
    ----------
    link
        The connection.
    sent
        The last sequence number that this program sent over an earlier connection, if any.

    Attributes
    ----------
    sequence
        The last sequence number sent.
    """

    def __init__(self, link: Link[RequestT, ReplyT], sent: int | None) -> None:
        answered = _answered(link)
        self._link = link
        self.sequence = following(sent if sent is not None and is_ahead(sent, of=answered) else answered)

    def ask(self, request: RequestT, seconds: float) -> ReplyT:
        """Give a request its number, write it, and return its reply.

        Raises
        ------
        LinkError
            If the controller does not acknowledge the request within `seconds`, or replies to another one.
        """
        end = time.monotonic() + seconds
        self.sequence = following(self.sequence)
        self._link.write(request.numbered(self.sequence))
        while (reply := self._reply()) is None:
            if time.monotonic() > end:
                raise LinkError(
                    f"the controller acknowledged request {_answered(self._link)}, expected {self.sequence} "
                    f"within {seconds:g} s; check that its program runs, and that no other client commands it"
                )
            time.sleep(ACKNOWLEDGE_POLL)
        if (reply.verb, reply.key) != (request.verb, request.key):
            raise LinkError(
                f"request {self.sequence} was answered as verb {reply.verb} for key {reply.key}, expected "
                f"{int(request.verb)} for {request.key}; make sure that only one client commands the "
                "controller"
            )
        return reply

    def close(self) -> None:
        """Close the connection."""
        self._link.close()

    def _reply(self) -> ReplyT | None:
        """Return the reply to the last request, or None if it is not there yet."""
        try:
            reply = self._link.read()
        except GarbageError as garbage:
            if garbage.sequence == self.sequence:
                raise
            return None
        return reply if reply.sequence == self.sequence else None


def _answered(link: Link[RequestT, ReplyT]) -> int:
    """Return the sequence of the latest reply, whose other values may predate the controller's program."""
    try:
        return link.read().sequence
    except GarbageError as garbage:
        return garbage.sequence
