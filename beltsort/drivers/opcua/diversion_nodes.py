"""Encoding of requests and replies about diversions in nodes, as in `nodes`."""

from dataclasses import astuple
from typing import Any

from beltsort.drivers.fieldbus.diversions import (
    EMERGENCY_STOP_PRESSED,
    MOVING,
    VERSION,
    DiversionReply,
    DiversionRequest,
    checked_diversion,
)
from beltsort.drivers.fieldbus.wire import GarbageError
from beltsort.drivers.opcua.nodes import NodeLayout

REQUEST = "DiversionRequest"
REQUEST_LENGTH = 7
ANSWER = "DiversionAnswer"
ANSWER_LENGTH = 13
BINS = "DiversionBins"


def encode_request(request: DiversionRequest) -> list[int]:
    """Return the value of the node DiversionRequest."""
    return [int(number) for number in astuple(request)]


def decode_request(value: Any) -> DiversionRequest | None:
    """Return the request in the node DiversionRequest, or None if it is not one."""
    if isinstance(value, list) and len(value) == REQUEST_LENGTH:
        return DiversionRequest(*value)
    return None


def encode_reply(reply: DiversionReply) -> list[Any]:
    """Return the values of the nodes of a reply."""
    *numbers, bins = astuple(reply)
    return [[VERSION, *(int(number) for number in numbers)], list(bins)]


def decode_reply(values: list[Any]) -> DiversionReply:
    """Return the reply in its nodes.

    Raises
    ------
    MissingPartError
        If its version is 0.
    GarbageError
        If it is invalid.
    """
    answer, bins = values
    if not isinstance(answer, list) or len(answer) != ANSWER_LENGTH:
        raise GarbageError(ANSWER, answer, f"{ANSWER_LENGTH} numbers", 0)
    *head, moving, emergency_stop, queued, forgotten = answer
    version, sequence, verb, key, phase, reason, boot, position, stamp = head
    return checked_diversion(
        version=version,
        sequence=sequence,
        verb=verb,
        key=key,
        phase=phase,
        reason=reason,
        boot=boot,
        position=position,
        stamp=stamp,
        flags=MOVING * bool(moving) | EMERGENCY_STOP_PRESSED * bool(emergency_stop),
        queued=queued,
        forgotten=forgotten,
        bins=bins,
    )


DIVERSION_NODES = NodeLayout(
    REQUEST, (ANSWER, BINS), encode_request, decode_request, encode_reply, decode_reply
)
"""The nodes of diversions."""
