"""Requests and replies about diversions in nodes, in registers, and in messages of ROS 2."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.drivers.fieldbus.diversions import (
    DiversionPhase,
    DiversionReason,
    DiversionReply,
    DiversionRequest,
    DiversionVerb,
)
from beltsort.drivers.fieldbus.link import MissingPartError
from beltsort.drivers.fieldbus.wire import MAX_BINS, GarbageError
from beltsort.drivers.modbus.diversion_registers import DIVERSION_REGISTERS
from beltsort.drivers.modbus.registers import REGISTERS
from beltsort.drivers.opcua.diversion_nodes import DIVERSION_NODES
from beltsort.drivers.ros2 import diversion_messages
from tests.laws import cases

u16, u32, i32 = st.integers(0, 2**16 - 1), st.integers(0, 2**32 - 1), st.integers(-(2**31), 2**31 - 1)
i64, keys = st.integers(-(2**63) + 1, 2**63 - 1), st.integers(0, 2**63 - 1)
requests = st.builds(DiversionRequest, u16, st.sampled_from(DiversionVerb), keys, i32, i64, i32, u32)
replies = st.builds(
    DiversionReply,
    sequence=u16,
    verb=u16,
    key=keys,
    phase=st.sampled_from(DiversionPhase),
    reason=st.sampled_from(DiversionReason),
    boot=st.integers(1, 2**32 - 1),
    position=i64,
    stamp=keys,
    moving=st.booleans(),
    emergency_stop=st.booleans(),
    queued=u16,
    forgotten=u32,
    bins=st.lists(u16, max_size=MAX_BINS).map(tuple),
)
REQUEST = DiversionRequest(1, DiversionVerb.DIVERT, 0x0102030405060708, -2, -3, 4, 5)
REPLY = DiversionReply(
    sequence=1,
    verb=6,
    key=3,
    phase=DiversionPhase.TOO_LATE,
    reason=DiversionReason.BIN_FULL,
    boot=8,
    position=9,
    stamp=10,
    moving=True,
    emergency_stop=True,
    queued=11,
    forgotten=12,
    bins=(13, 14),
)


@cases(100)
@given(requests, replies)
def test_what_is_written_is_what_is_read(request: DiversionRequest, reply: DiversionReply) -> None:
    modbus, opcua = DIVERSION_REGISTERS, DIVERSION_NODES
    words = modbus.encode_request(request)
    assert modbus.decode_request(words) == opcua.decode_request(opcua.encode_request(request)) == request
    assert len(words) == modbus.request_count
    words = modbus.encode_reply(reply)
    assert modbus.decode_reply(words) == opcua.decode_reply(opcua.encode_reply(reply)) == reply
    assert len(words) == modbus.reply_count
    assert all(0 <= word < 2**16 for word in words)
    ros2 = diversion_messages
    assert ros2.decode_request(ros2.encode_request(request)) == request
    assert ros2.decode_reply(ros2.encode_reply(reply)) == reply


def test_the_registers_are_those_of_the_specification() -> None:
    layout = DIVERSION_REGISTERS
    ones = 0xFFFF
    request = dict(enumerate(layout.encode_request(REQUEST), layout.request_at))
    assert [request[at] for at in range(200, 216)] == [
        *(1, 6),
        *(0x0102, 0x0304, 0x0506, 0x0708),
        *(ones, ones - 1),
        *(ones, ones, ones, ones - 2),
        *(0, 4),
        *(0, 5),
    ]
    reply = dict(enumerate(layout.encode_reply(REPLY), layout.reply_at))
    last_words = {300: 1, 301: 1, 302: 6, 306: 3, 307: 4, 308: 7, 310: 8, 314: 9, 318: 10, 319: 3}
    rest = {320: 11, 322: 12, 323: 2, 324: 13, 325: 14}
    assert {at: word for at, word in reply.items() if word} == last_words | rest
    assert max(reply) == 355


def test_the_registers_of_belt_and_sorter_are_others() -> None:
    taken = [
        set(range(at, at + count))
        for layout in (REGISTERS, DIVERSION_REGISTERS)
        for at, count in (
            (layout.request_at, layout.request_count),
            (layout.reply_at, layout.reply_count),
        )
    ]
    assert len(set().union(*taken)) == sum(map(len, taken))


def test_the_nodes_are_those_of_the_specification() -> None:
    assert DIVERSION_NODES.encode_request(REQUEST) == [1, 6, 0x0102030405060708, -2, -3, 4, 5]
    assert DIVERSION_NODES.encode_reply(REPLY) == [[1, 1, 6, 3, 4, 7, 8, 9, 10, 1, 1, 11, 12], [13, 14]]


def test_the_messages_are_those_of_the_specification() -> None:
    encoded = diversion_messages.encode_request(REQUEST)
    assert encoded == [1, 1, 6, 0x0102030405060708, -2, -3, 4, 5]
    assert diversion_messages.encode_reply(REPLY) == [1, 1, 6, 3, 4, 7, 8, 9, 10, 1, 1, 11, 12, 13, 14]


def test_messages_of_another_version_or_length_are_none_of_diversions() -> None:
    encoded = diversion_messages.encode_request(REQUEST)
    for request in ([], encoded[:-1], [*encoded, 0], [2, *encoded[1:]]):
        assert diversion_messages.decode_request(request) is None
    encoded = diversion_messages.encode_reply(REPLY)
    with pytest.raises(MissingPartError):
        diversion_messages.decode_reply([0, *encoded[1:]])
    for reply, said, sequence in (
        ([], r"\blength is 0\b", 0),
        (encoded[:12], r"\blength is 12, expected 13 numbers\b", 1),
        ([2, 9, *encoded[2:]], r"\bversion is 2\b", 9),
        ([*encoded, *range(MAX_BINS)], r"\bnumber of bins is 34\b", 1),
    ):
        with pytest.raises(GarbageError, match=said) as error:
            diversion_messages.decode_reply(reply)
        assert error.value.sequence == sequence


def test_registers_that_hold_nothing_are_no_diversions() -> None:
    with pytest.raises(MissingPartError):
        DIVERSION_REGISTERS.decode_reply([0] * DIVERSION_REGISTERS.reply_count)


def test_a_reply_that_is_none_is_garbage() -> None:
    assert DIVERSION_NODES.decode_request([1, 2]) is None
    with pytest.raises(GarbageError, match="DiversionAnswer"):
        DIVERSION_NODES.decode_reply([None, []])
    words = DIVERSION_REGISTERS.encode_reply(REPLY)
    with pytest.raises(GarbageError, match="bins"):
        DIVERSION_REGISTERS.decode_reply([*words[:23], 33, *words[24:]])


def test_numbers_too_large_become_the_largest() -> None:
    large = replace(REPLY, queued=2**40, forgotten=2**40, bins=(2**40,))
    read = DIVERSION_REGISTERS.decode_reply(DIVERSION_REGISTERS.encode_reply(large))
    assert (read.queued, read.forgotten, read.bins) == (2**16 - 1, 2**32 - 1, (2**16 - 1,))
