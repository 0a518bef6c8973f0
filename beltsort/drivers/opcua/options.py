"""How a controller is reached over OPC UA."""

from dataclasses import dataclass
from urllib.parse import urlparse

from beltsort.drivers.fieldbus.loopback import check_loopback
from beltsort.errors import CellError

POLICIES = ("Basic256Sha256", "Aes128Sha256RsaOaep", "Aes256Sha256RsaPss")


@dataclass(frozen=True)
class OpcuaOptions:
    """How a controller is reached over OPC UA. Messages are signed and encrypted.

    Attributes
    ----------
    endpoint
        For example "opc.tcp://192.168.0.5:4840/beltsort".
    certificate, private_key
        This program's own, PEM files.
    trust
        Folder of the certificates, .pem or .der, that the server's must be one of or issued by.
    policy
        Security policy.
    answer_timeout
        Seconds that the controller may take to acknowledge a request.
    allow_insecure
        Leave out security, on this computer only; then no files are needed.
    """

    endpoint: str
    certificate: str = ""
    private_key: str = ""
    trust: str = ""
    policy: str = "Basic256Sha256"
    answer_timeout: float = 2.0
    allow_insecure: bool = False

    def __post_init__(self) -> None:
        """Refuse what cannot work, and what would be insecure by accident."""
        if urlparse(self.endpoint).scheme != "opc.tcp":
            raise CellError(f"endpoint is {self.endpoint!r}, expected 'opc.tcp://host:port/path'")
        if self.policy not in POLICIES:
            raise CellError(f"policy is {self.policy!r}, expected one of {', '.join(POLICIES)}")
        if not self.answer_timeout > 0.0:
            raise CellError(f"answer_timeout is {self.answer_timeout}, expected seconds above 0")
        if self.allow_insecure:
            check_loopback(urlparse(self.endpoint).hostname or "")
        elif not (self.certificate and self.private_key and self.trust):
            raise CellError(
                f"certificate, private_key and trust are {self.certificate!r}, {self.private_key!r} and "
                f"{self.trust!r}, expected paths; docs/fieldbus.md says how to make them"
            )
