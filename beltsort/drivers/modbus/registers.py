"""Encoding of requests and replies in holding registers; numbers in several registers are big-endian."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic

from beltsort.drivers.fieldbus.link import ReplyT, RequestT
from beltsort.drivers.fieldbus.wire import (
    EMERGENCY_STOP,
    MAX_BINS,
    READY,
    GarbageError,
    Reply,
    Request,
    checked,
)


@dataclass(frozen=True)
class RegisterLayout(Generic[RequestT, ReplyT]):
    """Where requests and replies are, and how they are encoded.

    Attributes
    ----------
    request_at, request_count
        Address of a request's first register, and number of registers.
    reply_at, reply_count
        The same of a reply.
    encode_request, decode_request, encode_reply, decode_reply
        Functions from messages to registers, and back.
    """

    request_at: int
    request_count: int
    reply_at: int
    reply_count: int
    encode_request: Callable[[RequestT], list[int]]
    decode_request: Callable[[Sequence[int]], RequestT]
    encode_reply: Callable[[ReplyT], list[int]]
    decode_reply: Callable[[Sequence[int]], ReplyT]


REQUEST = struct.Struct(">HHiq")
"""sequence, verb, target, key"""

REPLY = struct.Struct(f">HHqHHIIiHIHHH{MAX_BINS}H")
"""sequence, verb, key, phase, reason, age, boot, position, remembered, forgotten, flags, fault, bins ..."""

REQUEST_AT, REPLY_AT = 0, 100
"""Addresses of the first registers."""

REQUEST_COUNT, REPLY_COUNT = REQUEST.size // 2, REPLY.size // 2

U16, U32 = 2**16 - 1, 2**32 - 1


def encode_request(request: Request) -> list[int]:
    """Return the registers of a request."""
    return words_of(REQUEST.pack(request.sequence, request.verb, request.target, request.key))


def decode_request(words: Sequence[int]) -> Request:
    """Return the request in its registers."""
    return Request(*REQUEST.unpack(bytes_of(words)))


def encode_reply(reply: Reply) -> list[int]:
    """Return the registers of a reply; numbers that do not fit are saturated."""
    answer = (reply.sequence, reply.verb, reply.key, reply.phase, reply.reason, min(reply.age, U32))
    memory = (min(reply.remembered, U16), reply.forgotten % (U32 + 1))
    flags = READY * reply.ready | EMERGENCY_STOP * reply.emergency_stop
    state = (reply.boot, reply.position, *memory, flags, reply.fault)
    return words_of(REPLY.pack(*answer, *state, *encode_bins(reply.bins)))


def decode_reply(words: Sequence[int]) -> Reply:
    """Return the reply in its registers. Raises `GarbageError` if it is invalid."""
    answer = REPLY.unpack(bytes_of(words))
    names = (
        *("sequence", "verb", "key", "phase", "reason", "age", "boot", "position"),
        *("remembered", "forgotten", "flags", "fault"),
    )
    values = dict(zip(names, answer, strict=False))
    return checked(**values, bins=decode_bins(answer[len(names) :], values["sequence"]))


def encode_bins(bins: Sequence[int]) -> list[int]:
    """Return the number of bins, and the objects in each, for as many bins as a reply can have."""
    return [len(bins), *(min(count, U16) for count in bins), *[0] * (MAX_BINS - len(bins))]


def decode_bins(words: Sequence[int], sequence: int) -> Sequence[int]:
    """Return the objects in each bin.

    Raises
    ------
    GarbageError
        If there are too many in the reply with this sequence.
    """
    number = words[0]
    if number > MAX_BINS:
        raise GarbageError("number of bins", number, f"0 to {MAX_BINS}", sequence)
    return words[1:][:number]


def words_of(data: bytes) -> list[int]:
    """Return the registers that contain bytes, two in each."""
    return list(struct.unpack(f">{len(data) // 2}H", data))


def bytes_of(words: Sequence[int]) -> bytes:
    """Return the bytes that are in registers."""
    return struct.pack(f">{len(words)}H", *words)


REGISTERS = RegisterLayout(
    REQUEST_AT,
    REQUEST_COUNT,
    REPLY_AT,
    REPLY_COUNT,
    encode_request,
    decode_request,
    encode_reply,
    decode_reply,
)
"""The registers of belt and sorter."""
