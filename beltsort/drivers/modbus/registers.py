"""Encoding of requests and replies in holding registers; numbers in several registers are big-endian."""

import struct
from collections.abc import Sequence

from beltsort.drivers.fieldbus.wire import (
    EMERGENCY_STOP,
    MAX_BINS,
    READY,
    GarbageError,
    Reply,
    Request,
    checked,
)

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
    return _words(REQUEST.pack(request.sequence, request.verb, request.target, request.key))


def decode_request(words: Sequence[int]) -> Request:
    """Return the request in its registers."""
    return Request(*REQUEST.unpack(_bytes(words)))


def encode_reply(reply: Reply) -> list[int]:
    """Return the registers of a reply; numbers that do not fit are saturated."""
    answer = (reply.sequence, reply.verb, reply.key, reply.phase, reply.reason, min(reply.age, U32))
    memory = (min(reply.remembered, U16), reply.forgotten % (U32 + 1))
    flags = READY * reply.ready | EMERGENCY_STOP * reply.emergency_stop
    counts = [min(count, U16) for count in reply.bins]
    unused = [0] * (MAX_BINS - len(counts))
    state = (reply.boot, reply.position, *memory, flags, reply.fault, len(counts))
    return _words(REPLY.pack(*answer, *state, *counts, *unused))


def decode_reply(words: Sequence[int]) -> Reply:
    """Return the reply in its registers. Raises `GarbageError` if it is invalid."""
    answer = REPLY.unpack(_bytes(words))
    names = (
        *("sequence", "verb", "key", "phase", "reason", "age", "boot", "position"),
        *("remembered", "forgotten", "flags", "fault"),
    )
    values = dict(zip(names, answer, strict=False))
    number = answer[len(names)]
    if number > MAX_BINS:
        raise GarbageError("number of bins", number, f"0 to {MAX_BINS}", values["sequence"])
    return checked(**values, bins=answer[len(names) + 1 :][:number])


def _words(data: bytes) -> list[int]:
    return list(struct.unpack(f">{len(data) // 2}H", data))


def _bytes(words: Sequence[int]) -> bytes:
    return struct.pack(f">{len(words)}H", *words)
