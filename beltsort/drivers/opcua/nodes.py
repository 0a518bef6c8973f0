"""Encoding of requests and replies in nodes, in the order in which they are read and written."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic

from beltsort.drivers.fieldbus.link import ReplyT, RequestT
from beltsort.drivers.fieldbus.wire import (
    EMERGENCY_STOP,
    READY,
    GarbageError,
    Reply,
    Request,
    checked,
)


@dataclass(frozen=True)
class NodeLayout(Generic[RequestT, ReplyT]):
    """The nodes of requests and replies, and how these are encoded.

    Attributes
    ----------
    request
        Name of the node of requests.
    reply
        Names of the nodes of a reply; the first contains the sequence, and is written last.
    encode_request, decode_request
        Functions from requests to the node's value, and back; None for what is no request.
    encode_reply, decode_reply
        Functions from replies to the nodes' values, and back.
    """

    request: str
    reply: tuple[str, ...]
    encode_request: Callable[[RequestT], list[int]]
    decode_request: Callable[[Any], RequestT | None]
    encode_reply: Callable[[ReplyT], list[Any]]
    decode_reply: Callable[[list[Any]], ReplyT]


NAMESPACE = "urn:beltsort:controller"
FOLDER = "Beltsort"
REQUEST = "Request"
REQUEST_LENGTH = 4
ANSWER = "Answer"
ANSWER_LENGTH = 6
STATE = ("BootId", "Position", "Remembered", "Forgotten", "Ready", "EmergencyStop", "Fault", "Bins")
REPLY = (ANSWER, *STATE)


def node_id(index: int, name: str) -> str:
    """Return the id of a node, given the index of the namespace."""
    return f"ns={index};s={FOLDER}.{name}"


def encode_request(request: Request) -> list[int]:
    """Return the value of the node Request."""
    return [request.sequence, int(request.verb), request.target, request.key]


def decode_request(value: Any) -> Request | None:
    """Return the request in the node Request, or None if it is not one."""
    return Request(*value) if isinstance(value, list) and len(value) == REQUEST_LENGTH else None


def encode_reply(reply: Reply) -> list[Any]:
    """Return the values of the nodes `REPLY`."""
    answer = [reply.sequence, int(reply.verb), reply.key, int(reply.phase), int(reply.reason), reply.age]
    state = [reply.boot, reply.position, reply.remembered, reply.forgotten]
    return [answer, *state, reply.ready, reply.emergency_stop, int(reply.fault), list(reply.bins)]


def decode_reply(values: list[Any]) -> Reply:
    """Return the reply in the nodes `REPLY`. Raises `GarbageError` if it is invalid."""
    answer, boot, position, remembered, forgotten, ready, emergency_stop, fault, bins = values
    if not isinstance(answer, list) or len(answer) != ANSWER_LENGTH:
        raise GarbageError(ANSWER, answer, f"{ANSWER_LENGTH} numbers", 0)
    sequence, verb, key, phase, reason, age = answer
    return checked(
        sequence=sequence,
        verb=verb,
        key=key,
        phase=phase,
        reason=reason,
        age=age,
        boot=boot,
        position=position,
        remembered=remembered,
        forgotten=forgotten,
        flags=READY * bool(ready) | EMERGENCY_STOP * bool(emergency_stop),
        fault=fault,
        bins=bins,
    )


NODES = NodeLayout(REQUEST, REPLY, encode_request, decode_request, encode_reply, decode_reply)
"""The nodes of belt and sorter."""
