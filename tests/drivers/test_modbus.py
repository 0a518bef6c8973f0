"""What is particular to Modbus: registers, frames and names in certificates."""

import json
import socket
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymodbus.client import ModbusTcpClient

from beltsort.cell import CommandError, Outcome
from beltsort.cell.protocols import NOWHERE
from beltsort.drivers.fieldbus.wire import MAX_BINS, Phase, Reply, Request, Verb
from beltsort.drivers.modbus import ModbusOptions, make, make_diverter
from beltsort.drivers.modbus.registers import (
    REPLY_AT,
    REPLY_COUNT,
    REQUEST_AT,
    REQUEST_COUNT,
    decode_reply,
    decode_request,
    encode_reply,
    encode_request,
)
from beltsort.errors import CellError
from tests.contract.peers import ModbusPeer, ModbusTlsPeer
from tests.laws import cases
from tests.second.process import Controller, built

pytestmark = pytest.mark.process

u16, u32, i32 = st.integers(0, 2**16 - 1), st.integers(0, 2**32 - 1), st.integers(-(2**31), 2**31 - 1)
keys = st.integers(0, 2**63 - 1)
requests = st.builds(Request, u16, st.sampled_from(Verb), i32, keys)
replies = st.builds(
    Reply,
    sequence=u16,
    verb=u16,
    key=keys,
    phase=st.sampled_from(Phase),
    reason=u16,
    age=u32,
    boot=st.integers(1, 2**32 - 1),
    position=st.integers(NOWHERE, 2**31 - 1),
    remembered=u16,
    forgotten=u32,
    ready=st.booleans(),
    emergency_stop=st.booleans(),
    fault=u16,
    bins=st.lists(u16, max_size=MAX_BINS).map(tuple),
)

WRITE = 16
"""The Modbus function "write multiple registers"."""


@cases(50)
@given(requests, replies)
def test_what_is_written_is_what_is_read(request: Request, reply: Reply) -> None:
    assert decode_request(encode_request(request)) == request
    assert decode_reply(encode_reply(reply)) == reply
    assert (len(encode_request(request)), len(encode_reply(reply))) == (REQUEST_COUNT, REPLY_COUNT)


def test_the_registers_are_those_of_the_specification() -> None:
    assert encode_request(Request(7, Verb.SORT, -2, 0x0102030405060708)) == [
        *(7, 2),
        *(0xFFFF, 0xFFFE),
        *(0x0102, 0x0304, 0x0506, 0x0708),
    ]


def test_the_reply_is_where_the_specification_says() -> None:
    reply = Reply(
        sequence=1,
        verb=2,
        key=3,
        phase=Phase.BROKEN_OFF,
        reason=5,
        age=6,
        boot=7,
        position=8,
        remembered=9,
        forgotten=10,
        ready=True,
        emergency_stop=False,
        fault=12,
        bins=(13, 14),
    )
    words = dict(enumerate(encode_reply(reply), REPLY_AT))
    last_words = {100: 1, 101: 2, 105: 3, 106: 4, 107: 5, 109: 6, 111: 7, 113: 8, 114: 9, 116: 10, 117: 1}
    bins = {118: 12, 119: 2, 120: 13, 121: 14}
    assert {address: word for address, word in words.items() if word} == last_words | bins


@cases(5)
@given(replies, st.integers(2**32, 2**40))
def test_numbers_too_large_become_the_largest(reply: Reply, large: int) -> None:
    read = decode_reply(encode_reply(replace(reply, age=large, bins=(large,))))
    assert (read.age, read.bins) == (2**32 - 1, (2**16 - 1,))


@pytest.fixture(scope="module")
def peer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModbusPeer]:
    peer = ModbusPeer(tmp_path_factory.mktemp("plain"))
    try:
        peer.start("--home", "0")
        yield peer
    finally:
        peer.close()


def test_the_server_takes_whole_requests_only(peer: ModbusPeer) -> None:
    with ModbusTcpClient("127.0.0.1", port=peer.port, retries=0) as client:
        assert client.write_registers(REQUEST_AT, [1] * (REQUEST_COUNT - 1)).isError()
        assert client.write_register(REPLY_AT, 1).isError()
        assert not client.write_registers(REQUEST_AT, encode_request(Request(1, Verb.LOOK))).isError()


def test_a_server_without_diversions_is_told(peer: ModbusPeer, tmp_path: Path) -> None:
    """Whether it lacks the registers, or has some there that hold nothing, as the controller in C has."""
    second = Controller(built(tmp_path), tmp_path)
    try:
        for port, said in ((peer.port, "300 to 355"), (second.port, "is 0")):
            belt = make_diverter(ModbusOptions("127.0.0.1", port, allow_insecure=True))
            with pytest.raises(CellError, match=rf"\bno diversions\b.*\b{said}\b"):
                belt.reading()
            belt.close()
    finally:
        second.kill()


def test_a_name_that_is_not_in_the_certificate_is_refused(tmp_path: Path) -> None:
    peer = ModbusTlsPeer(tmp_path)
    try:
        peer.start("--home", "0")
        own = peer.client
        files = (str(own.certificate), str(own.private_key), str(own.trust))
        for name, fits in (("localhost", True), ("plc.example", False)):
            device = make(ModbusOptions("127.0.0.1", peer.port, *files, server_name=name))
            if fits:
                device.sort(0, "sort")
                device.close()
            else:
                with pytest.raises(CommandError, match="certificate") as error:
                    device.sort(0, "other")
                assert error.value.outcome is Outcome.NOT_DONE
    finally:
        peer.close()


def test_a_write_without_an_answer_is_not_repeated() -> None:
    """A server that acknowledges what is read, and keeps silent about what is written."""
    writes: list[bytes] = []

    def serve(listener: socket.socket) -> None:
        connection, _ = listener.accept()
        with connection:
            while frame := connection.recv(256):
                transaction, _, _, unit, function = struct.unpack(">HHHBB", frame[:8])
                if function == WRITE:
                    writes.append(frame)
                    continue
                registers = struct.pack(f">B{REPLY_COUNT}H", 2 * REPLY_COUNT, *[0] * REPLY_COUNT)
                connection.sendall(
                    struct.pack(">HHHBB", transaction, 0, 2 + len(registers), unit, function) + registers
                )

    with socket.create_server(("127.0.0.1", 0)) as listener:
        Thread(target=serve, args=(listener,), daemon=True).start()
        port = listener.getsockname()[1]
        device = make(ModbusOptions("127.0.0.1", port, answer_timeout=2.0, allow_insecure=True))
        with pytest.raises(CommandError):
            device.stop()
    assert len(writes) == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"port": 0}, r"\bport\b.*\b0\b.*\b1\b.*\b65535\b"),
        ({"port": 502, "unit": 256}, r"\bunit\b.*\b256\b.*\b0\b.*\b255\b"),
        ({"port": 502}, r"certificate, private_key and trust\b.*\btunnel\b"),
        ({"port": 502, "allow_insecure": True}, r"'192\.168\.0\.5'.*\b127\.0\.0\.1\b"),
        (
            {"host": "127.0.0.1", "port": 502, "allow_insecure": True, "answer_timeout": -1.0},
            r"\banswer_timeout\b.*-1\.0\b.*\b0\b",
        ),
    ],
)
def test_options_without_sense_are_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        ModbusOptions(**{"host": "192.168.0.5", **options})


def test_the_panel_names_its_buttons(peer: ModbusPeer) -> None:
    assert "press, release" in json.dumps(peer.push("explode"))
