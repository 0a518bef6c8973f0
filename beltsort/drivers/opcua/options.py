"""Options of the connection over OPC UA."""

from dataclasses import dataclass
from urllib.parse import urlparse

from beltsort.drivers.fieldbus.security import check_loopback
from beltsort.errors import CellError

POLICIES = ("Basic256Sha256", "Aes128Sha256RsaOaep", "Aes256Sha256RsaPss")


@dataclass(frozen=True)
class OpcuaOptions:
    """Options of the connection over OPC UA. Messages are signed and encrypted.

    Attributes
    ----------
    endpoint
        For example "opc.tcp://192.168.0.5:4840/beltsort".
    certificate, private_key
        PEM files of this client.
    trust
        Folder of trusted certificates, .pem or .der: the server's own, or that of its issuer.
    policy
        Security policy.
    answer_timeout
        Timeout of the acknowledgement of a request, seconds.
    allow_insecure
        Disable security, on this computer only; then no files are needed.
    """

    endpoint: str
    certificate: str = ""
    private_key: str = ""
    trust: str = ""
    policy: str = "Basic256Sha256"
    answer_timeout: float = 2.0
    allow_insecure: bool = False

    def __post_init__(self) -> None:
        """Reject invalid values, and insecure connections to other computers."""
        if urlparse(self.endpoint).scheme != "opc.tcp":
            raise CellError(
                f"endpoint is {self.endpoint!r}, expected 'opc.tcp://host:port/path'; give the server's "
                "address"
            )
        if self.policy not in POLICIES:
            raise CellError(f"policy is {self.policy!r}, expected one of {', '.join(POLICIES)}; choose one")
        if not self.answer_timeout > 0.0:
            raise CellError(
                f"answer_timeout is {self.answer_timeout}, expected seconds above 0; start from the default, "
                "2"
            )
        if self.allow_insecure:
            check_loopback(urlparse(self.endpoint).hostname or "")
        elif not (self.certificate and self.private_key and self.trust):
            raise CellError(
                f"certificate, private_key and trust are {self.certificate!r}, {self.private_key!r} and "
                f"{self.trust!r}, expected paths; docs/fieldbus.md explains how to create them"
            )
