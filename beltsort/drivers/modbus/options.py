"""Options of the connection over Modbus."""

from dataclasses import dataclass

from beltsort.drivers.fieldbus.security import check_loopback
from beltsort.errors import CellError


@dataclass(frozen=True)
class ModbusOptions:
    """Options of the connection over Modbus TCP.

    The connection uses mutual TLS ("Modbus/TCP Security") unless `allow_insecure` is set.

    Attributes
    ----------
    host, port
        Address of the controller; the port is usually 802 with TLS, 502 without.
    certificate, private_key
        PEM files of this client.
    trust
        Folder of trusted certificates, .pem or .der: the controller's own, or that of its issuer.
    server_name
        Name or address that must be in the controller's certificate; empty: `host`.
    unit
        Modbus unit identifier of the controller.
    answer_timeout
        Timeout of the acknowledgement of a request, seconds.
    allow_insecure
        Disable TLS, on this computer only; then no files are needed.
    """

    host: str
    port: int
    certificate: str = ""
    private_key: str = ""
    trust: str = ""
    server_name: str = ""
    unit: int = 1
    answer_timeout: float = 2.0
    allow_insecure: bool = False

    def __post_init__(self) -> None:
        """Reject invalid values, and insecure connections to other computers."""
        if not 0 < self.port < 65536:
            raise CellError(f"port is {self.port}, expected 1 to 65535; give 802 with TLS or 502 without")
        if not 0 <= self.unit <= 255:
            raise CellError(f"unit is {self.unit}, expected 0 to 255; give the controller's, usually 1")
        if not self.answer_timeout > 0.0:
            raise CellError(
                f"answer_timeout is {self.answer_timeout}, expected seconds above 0; start from the default, "
                "2"
            )
        if self.allow_insecure:
            check_loopback(self.host)
        elif not (self.certificate and self.private_key and self.trust):
            raise CellError(
                f"certificate, private_key and trust are {self.certificate!r}, {self.private_key!r} and "
                f"{self.trust!r}, expected paths; docs/fieldbus.md says how to make them, and how to reach a "
                "controller without TLS through a tunnel of this computer"
            )
