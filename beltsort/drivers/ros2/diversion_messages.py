"""Encoding of requests and replies about diversions as the numbers of a std_msgs/Int64MultiArray."""

from collections.abc import Sequence
from dataclasses import astuple

from beltsort.drivers.fieldbus.diversions import (
    REPLY_NUMBERS,
    VERSION,
    DiversionReply,
    DiversionRequest,
    reply_numbers,
    reply_of,
)
from beltsort.drivers.fieldbus.wire import GarbageError

KIND = "std_msgs/Int64MultiArray"
"""Type of the messages; their layout is not used."""

REQUEST_LENGTH = 8
"""Version, sequence, verb, key, object, coordinate, bin, boot."""


def encode_request(request: DiversionRequest) -> list[int]:
    """Return the numbers of a request."""
    return [VERSION, *(int(number) for number in astuple(request))]


def decode_request(numbers: Sequence[int]) -> DiversionRequest | None:
    """Return the request with these numbers, or None if they are not one of this version."""
    if len(numbers) == REQUEST_LENGTH and numbers[0] == VERSION:
        return DiversionRequest(*numbers[1:])
    return None


def encode_reply(reply: DiversionReply) -> list[int]:
    """Return the numbers of a reply, the bins last."""
    return [*reply_numbers(reply), *reply.bins]


def decode_reply(numbers: Sequence[int]) -> DiversionReply:
    """Return the reply with these numbers.

    Raises
    ------
    MissingPartError
        If its version is 0.
    GarbageError
        If it is invalid.
    """
    if len(numbers) < REPLY_NUMBERS:
        sequence = numbers[1] if len(numbers) > 1 else 0
        raise GarbageError("length", len(numbers), f"{REPLY_NUMBERS} numbers, and the bins", sequence)
    return reply_of(numbers[:REPLY_NUMBERS], numbers[REPLY_NUMBERS:])
