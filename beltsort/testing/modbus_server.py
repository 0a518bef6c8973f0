"""A reference Modbus server: `python -m beltsort.testing.modbus_server`, with TLS if `--pki FOLDER` is given.

It prints its address as one line of JSON, reads buttons of the operator's panel from standard input, and ends
with standard input.
"""

import ssl
from argparse import Namespace
from pathlib import Path

from beltsort.drivers.fieldbus.wire import Reply, Request
from beltsort.drivers.modbus.registers import (
    REPLY_AT,
    REPLY_COUNT,
    REQUEST_AT,
    REQUEST_COUNT,
    decode_request,
    encode_reply,
)
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


class Registers:
    """The registers of the protocol. A request must be written in one write of all its registers."""

    def __init__(self, reply: Reply) -> None:
        self._request = [0] * REQUEST_COUNT
        self._reply = encode_reply(reply)

    async def request(self) -> Request:
        """Return the last request that a client wrote."""
        return decode_request(self._request)

    async def publish(self, reply: Reply) -> None:
        """Publish a reply to clients."""
        self._reply = encode_reply(reply)

    def device(self) -> SimDevice:
        """Return the registers as a pymodbus device."""
        request = SimData(REQUEST_AT, count=REQUEST_COUNT, datatype=DataType.REGISTERS)
        reply = SimData(REPLY_AT, count=REPLY_COUNT, datatype=DataType.REGISTERS)
        return SimDevice(ANY_UNIT, [request, reply], action=self._access)

    async def _access(
        self,
        _function: int,
        start: int,
        address: int,
        count: int,
        registers: list[int],
        written: list[int] | list[bool] | None,
    ) -> ExcCodes | None:
        """Allow clients to read all registers and to write complete requests only."""
        if written is None:
            registers[REPLY_AT - start : REPLY_AT - start + REPLY_COUNT] = self._reply
            return None
        if (address, count) != (REQUEST_AT, REQUEST_COUNT):
            return ExcCodes.ILLEGAL_ADDRESS
        self._request = [int(word) for word in written]
        return None


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
    registers = Registers(panel.shown())
    port = free_port(arguments)
    server = build(arguments, registers.device(), port)
    await server.serve_forever(background=True)
    await serve(registers, panel, {"host": arguments.host, "port": port})


if __name__ == "__main__":
    run(main(parser("beltsort.testing.modbus_server", "A reference Modbus server.").parse_args()))
