"""One Modbus connection."""

import socket
import ssl
from typing import Generic

from beltsort.drivers.fieldbus.link import LinkError, MissingPartError, ReplyT, RequestT
from beltsort.drivers.modbus.options import ModbusOptions
from beltsort.drivers.modbus.registers import RegisterLayout
from beltsort.drivers.modbus.tls import context
from beltsort.util.extras import extra

with extra("modbus"):
    from pymodbus.client import ModbusTcpClient
    from pymodbus.constants import ExcCodes
    from pymodbus.pdu import ExceptionResponse, ModbusPDU


class OneConnection(ModbusTcpClient):
    """A client on an open connection, which neither reconnects (that would bypass TLS) nor retries.

    Modbus over TLS uses the same frames as over TCP. pymodbus's own TLS client neither reassembles frames
    that arrive in parts nor verifies the server's name.
    """

    def __init__(self, connection: socket.socket, seconds: float) -> None:
        host, port = connection.getpeername()[:2]
        super().__init__(host, port=port, timeout=seconds, retries=0)
        self.socket = connection

    def connect(self) -> bool:
        """Return whether the connection is open."""
        return self.socket is not None


class ModbusLink(Generic[RequestT, ReplyT]):
    """A connection.

    Parameters
    ----------
    options
        Connection to the server.
    layout
        The registers.
    seconds
        Timeout of each call.
    """

    def __init__(
        self, options: ModbusOptions, layout: RegisterLayout[RequestT, ReplyT], seconds: float
    ) -> None:
        self._layout = layout
        self._unit = options.unit
        self._connection = _connected(options, seconds)
        self._client = OneConnection(self._connection, seconds)

    def write(self, request: RequestT) -> None:
        """Write a request."""
        words = self._layout.encode_request(request)
        _checked(self._client.write_registers(self._layout.request_at, words, device_id=self._unit))

    def read(self) -> ReplyT:
        """Read the latest reply."""
        at, count = self._layout.reply_at, self._layout.reply_count
        answer = self._client.read_holding_registers(at, count=count, device_id=self._unit)
        if isinstance(answer, ExceptionResponse) and answer.exception_code == ExcCodes.ILLEGAL_ADDRESS:
            raise MissingPartError(f"it has no registers {at} to {at + count - 1}")
        return self._layout.decode_reply(_checked(answer).registers)

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()


def _connected(options: ModbusOptions, seconds: float) -> socket.socket:
    connection = socket.create_connection((options.host, options.port), timeout=seconds)
    if options.allow_insecure:
        return connection
    try:
        tls = context(ssl.PROTOCOL_TLS_CLIENT, options.certificate, options.private_key, options.trust)
        return tls.wrap_socket(connection, server_hostname=options.server_name or options.host)
    except BaseException:
        connection.close()
        raise


def _checked(answer: ModbusPDU) -> ModbusPDU:
    if answer.isError():
        raise LinkError(
            f"the controller answered {answer}, expected registers; compare its program with docs/fieldbus.md"
        )
    return answer
