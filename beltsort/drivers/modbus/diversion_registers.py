"""Encoding of requests and replies about diversions in holding registers, as in `registers`."""

import struct
from collections.abc import Sequence

from beltsort.drivers.fieldbus.diversions import (
    EMERGENCY_STOP_PRESSED,
    MOVING,
    VERSION,
    DiversionReply,
    DiversionRequest,
    checked_diversion,
)
from beltsort.drivers.fieldbus.wire import MAX_BINS
from beltsort.drivers.modbus.registers import (
    U16,
    U32,
    RegisterLayout,
    bytes_of,
    decode_bins,
    encode_bins,
    words_of,
)

REQUEST = struct.Struct(">HHqiqiI")
"""sequence, verb, key, object, coordinate, bin, boot"""

REPLY = struct.Struct(f">HHHqHHIqqHHIH{MAX_BINS}H")
"""version, sequence, verb, key, phase, reason, boot, position, stamp, flags, queued, forgotten, bins ..."""


def encode_request(request: DiversionRequest) -> list[int]:
    """Return the registers of a request."""
    order = (request.key, request.object, request.coordinate, request.bin, request.boot & U32)
    return words_of(REQUEST.pack(request.sequence, request.verb, *order))


def decode_request(words: Sequence[int]) -> DiversionRequest:
    """Return the request in its registers."""
    return DiversionRequest(*REQUEST.unpack(bytes_of(words)))


def encode_reply(reply: DiversionReply) -> list[int]:
    """Return the registers of a reply; numbers that do not fit are saturated."""
    answer = (VERSION, reply.sequence, reply.verb, reply.key, reply.phase, reply.reason)
    flags = MOVING * reply.moving | EMERGENCY_STOP_PRESSED * reply.emergency_stop
    state = (reply.boot, reply.position, reply.stamp, flags, min(reply.queued, U16))
    forgotten = min(reply.forgotten, U32)
    return words_of(REPLY.pack(*answer, *state, forgotten, *encode_bins(reply.bins)))


def decode_reply(words: Sequence[int]) -> DiversionReply:
    """Return the reply in its registers.

    Raises
    ------
    MissingPartError
        If its version is 0: the controller has registers there, but no diversions.
    GarbageError
        If it is invalid.
    """
    answer = REPLY.unpack(bytes_of(words))
    names = (
        *("version", "sequence", "verb", "key", "phase", "reason", "boot"),
        *("position", "stamp", "flags", "queued", "forgotten"),
    )
    values = dict(zip(names, answer, strict=False))
    return checked_diversion(**values, bins=decode_bins(answer[len(names) :], values["sequence"]))


DIVERSION_REGISTERS = RegisterLayout(
    200,
    REQUEST.size // 2,
    300,
    REPLY.size // 2,
    encode_request,
    decode_request,
    encode_reply,
    decode_reply,
)
"""The registers of diversions."""
