"""How a controller is reached over Modbus."""

from dataclasses import dataclass

from beltsort.drivers.fieldbus.loopback import check_loopback
from beltsort.errors import CellError


@dataclass(frozen=True)
class ModbusOptions:
    """How a controller is reached over Modbus TCP.

    With mutual TLS ("Modbus/TCP Security"), or plain if `allow_insecure` says so.

    Attributes
    ----------
    host, port
        Where the controller listens; usually 802 with TLS, 502 without.
    certificate, private_key
        This program's own, PEM files.
    trust
        Folder of the certificates, .pem or .der, that the controller's must be one of or issued by.
    server_name
        Name or address that must be in the controller's certificate; empty: `host`.
    unit
        Modbus unit identifier of the controller.
    answer_timeout
        Seconds that the controller may take to acknowledge a request.
    allow_insecure
        Leave TLS out, on this computer only; then no files are needed.
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
        """Refuse what cannot work, and what would be insecure by accident."""
        if not 0 < self.port < 65536:
            raise CellError(f"port is {self.port}, expected 1 to 65535; usually 802 with TLS, 502 without")
        if not 0 <= self.unit <= 255:
            raise CellError(f"unit is {self.unit}, expected 0 to 255; usually 1")
        if not self.answer_timeout > 0.0:
            raise CellError(f"answer_timeout is {self.answer_timeout}, expected seconds above 0")
        if self.allow_insecure:
            check_loopback(self.host)
        elif not (self.certificate and self.private_key and self.trust):
            raise CellError(
                f"certificate, private_key and trust are {self.certificate!r}, {self.private_key!r} and "
                f"{self.trust!r}, expected paths; docs/fieldbus.md says how to make them, and how to reach a "
                "controller without TLS through a tunnel of this computer"
            )
