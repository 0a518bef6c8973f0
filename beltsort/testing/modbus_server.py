"""A reference Modbus server: `python -m beltsort.testing.modbus_server`, with TLS if `--pki FOLDER` is given.

It prints its address as one line of JSON, reads buttons of the operator's panel from standard input, and ends
with standard input.
"""

import ssl
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Generic

from beltsort.drivers.fieldbus.link import ReplyT, RequestT
from beltsort.drivers.modbus.diversion_registers import DIVERSION_REGISTERS
from beltsort.drivers.modbus.registers import REGISTERS, RegisterLayout
from beltsort.drivers.modbus.tls import context
from beltsort.testing.serving import Panel, free_port, parser, run, serve
from beltsort.util.extras import extra

with extra("modbus", program=__name__ == "__main__"):
    from pymodbus import FramerType
    from pymodbus.constants import ExcCodes
    from pymodbus.server import ModbusTcpServer, ModbusTlsServer
    from pymodbus.simulator import DataType, SimData, SimDevice

    from beltsort.drivers.fieldbus.pki import identity

ANY_UNIT = 0


class Registers(Generic[RequestT, ReplyT]):
    """The registers of a part of the protocol; a request must be written in one write of all of its own."""

    def __init__(self, layout: RegisterLayout[RequestT, ReplyT], reply: ReplyT) -> None:
        self._layout = layout
        self._request = [0] * layout.request_count
        self._reply = layout.encode_reply(reply)

    async def request(self) -> RequestT:
        """Return the last request that a client wrote."""
        return self._layout.decode_request(self._request)

    async def publish(self, reply: ReplyT) -> None:
        """Publish a reply to clients."""
        self._reply = self._layout.encode_reply(reply)

    def data(self) -> list[SimData]:
        """Return the registers for a pymodbus device."""
        layout = self._layout
        blocks = ((layout.request_at, layout.request_count), (layout.reply_at, layout.reply_count))
        return [SimData(at, count=count, datatype=DataType.REGISTERS) for at, count in blocks]

    def show(self, start: int, registers: list[int]) -> None:
        """Write the reply into registers, the first of which has the address `start`."""
        at = self._layout.reply_at - start
        registers[at : at + self._layout.reply_count] = self._reply

    def take(self, address: int, words: list[int]) -> bool:
        """Keep what a client writes; return whether it is a complete request."""
        if (address, len(words)) != (self._layout.request_at, self._layout.request_count):
            return False
        self._request = words
        return True


def device_of(parts: Sequence[Registers[Any, Any]]) -> SimDevice:
    """Return the registers of all parts as a pymodbus device."""

    async def access(
        _function: int,
        start: int,
        address: int,
        _count: int,
        registers: list[int],
        written: list[int] | list[bool] | None,
    ) -> ExcCodes | None:
        """Allow clients to read all registers and to write complete requests only."""
        if written is None:
            for part in parts:
                part.show(start, registers)
            return None
        words = [int(word) for word in written]
        return None if any(part.take(address, words) for part in parts) else ExcCodes.ILLEGAL_ADDRESS

    return SimDevice(ANY_UNIT, [block for part in parts for block in part.data()], action=access)


def build(arguments: Namespace, device: SimDevice, port: int) -> ModbusTcpServer:
    """Return the server."""
    address = (arguments.host, port)
    if not arguments.pki:
        return ModbusTcpServer(device, address=address)
    own = identity(Path(arguments.pki))
    tls = context(ssl.PROTOCOL_TLS_SERVER, str(own.certificate), str(own.private_key), str(own.trust))
    return ModbusTlsServer(device, framer=FramerType.SOCKET, sslctx=tls, address=address)


async def main(arguments: Namespace) -> None:
    """Serve until standard input ends."""
    panel = Panel(arguments)
    registers = Registers(REGISTERS, panel.shown())
    diversions = None
    if panel.diverting is not None:
        diversions = Registers(DIVERSION_REGISTERS, panel.diverting.look())
    port = free_port(arguments)
    parts: list[Registers[Any, Any]] = [registers] if diversions is None else [registers, diversions]
    server = build(arguments, device_of(parts), port)
    await server.serve_forever(background=True)
    await serve(panel, {"host": arguments.host, "port": port}, registers, diversions)


if __name__ == "__main__":
    run(main(parser("beltsort.testing.modbus_server", "A reference Modbus server.").parse_args()))
