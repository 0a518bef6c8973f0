"""One Modbus connection."""

import socket
import ssl

from beltsort.drivers.fieldbus.link import LinkError
from beltsort.drivers.fieldbus.wire import Reply, Request
from beltsort.drivers.modbus.options import ModbusOptions
from beltsort.drivers.modbus.registers import REPLY_AT, REPLY_COUNT, REQUEST_AT, decode_reply, encode_request
from beltsort.drivers.modbus.tls import context
from beltsort.util.extras import extra

with extra("modbus"):
    from pymodbus.client import ModbusTcpClient
    from pymodbus.pdu import ModbusPDU


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


class ModbusLink:
    """A connection.

    Parameters
    ----------
    options
        Connection to the server.
    seconds
        Timeout of each call.
    """

    def __init__(self, options: ModbusOptions, seconds: float) -> None:
        self._unit = options.unit
        self._connection = _connected(options, seconds)
        self._client = OneConnection(self._connection, seconds)

    def write(self, request: Request) -> None:
        """Write a request."""
        words = encode_request(request)
        _checked(self._client.write_registers(REQUEST_AT, words, device_id=self._unit))

    def read(self) -> Reply:
        """Read the latest reply."""
        answer = self._client.read_holding_registers(REPLY_AT, count=REPLY_COUNT, device_id=self._unit)
        return decode_reply(_checked(answer).registers)

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
