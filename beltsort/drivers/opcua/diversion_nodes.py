"""Encoding of requests and replies about diversions in nodes, as in `nodes`."""

from dataclasses import astuple
from typing import Any

from beltsort.drivers.fieldbus.diversions import (
    REPLY_NUMBERS,
    DiversionReply,
    DiversionRequest,
    reply_numbers,
    reply_of,
)
from beltsort.drivers.fieldbus.wire import GarbageError
from beltsort.drivers.opcua.nodes import NodeLayout

REQUEST = "DiversionRequest"
REQUEST_LENGTH = 7
ANSWER = "DiversionAnswer"
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
    return [reply_numbers(reply), list(reply.bins)]


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
    if not isinstance(answer, list) or len(answer) != REPLY_NUMBERS:
        raise GarbageError(ANSWER, answer, f"{REPLY_NUMBERS} numbers", 0)
    return reply_of(answer, bins)


DIVERSION_NODES = NodeLayout(
    REQUEST, (ANSWER, BINS), encode_request, decode_request, encode_reply, decode_reply
)
"""The nodes of diversions."""
