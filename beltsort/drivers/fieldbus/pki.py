"""Creation of keys and self-signed certificates for a client or a controller."""

import os
from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address
from pathlib import Path
from socket import gethostname

from beltsort.util.extras import extra

with extra("opcua", program=__name__ == "__main__"):
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import rsa
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

KEY_BITS = 2048
OWN_HOSTS = ("127.0.0.1", "localhost")
VALIDITY = timedelta(days=3650)


@dataclass(frozen=True)
class Identity:
    """Key and certificate of a client or a controller, and its trusted certificates.

    Attributes
    ----------
    certificate, private_key
        PEM files.
    trust
        Folder of trusted certificates.
    """

    certificate: Path
    private_key: Path
    trust: Path

    def admit(self, other: "Identity") -> None:
        """Add the other's certificate to the trusted ones."""
        name = f"{other.certificate.parent.name}.pem"
        (self.trust / name).write_bytes(other.certificate.read_bytes())


def identity(folder: Path, hosts: Sequence[str] = ()) -> Identity:
    """Return the identity stored in a folder; create it if there is none.

    The certificate is a self-signed RSA certificate for OPC UA and TLS, clients and servers. The key file is
    readable by its owner only.

    Parameters
    ----------
    folder
        Folder of `certificate.pem`, `key.pem` and `trusted`; its name becomes the certificate's common name.
    hosts
        Names and addresses of a server, in addition to this computer's name and the loopback.
    """
    own = Identity(folder / "certificate.pem", folder / "key.pem", folder / "trusted")
    own.trust.mkdir(parents=True, exist_ok=True)
    if not own.private_key.exists():
        key = rsa.generate_private_key(public_exponent=65537, key_size=KEY_BITS)
        own.certificate.write_bytes(_certificate(key, folder.name, [*OWN_HOSTS, gethostname(), *hosts]))
        _write_secret(own.private_key, key)
    return own


def application_uri(certificate: Path) -> str:
    """Return the OPC UA application URI in a certificate."""
    loaded = x509.load_pem_x509_certificate(certificate.read_bytes())
    names = loaded.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    return names.get_values_for_type(x509.UniformResourceIdentifier)[0]


def _write_secret(path: Path, key: rsa.RSAPrivateKey) -> None:
    pem = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(pem)


def _certificate(key: rsa.RSAPrivateKey, name: str, hosts: Sequence[str]) -> bytes:
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    now = datetime.now(UTC)
    builder = (
        x509.CertificateBuilder(issuer_name=subject, subject_name=subject, public_key=key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(minutes=5))  # clocks differ
        .not_valid_after(now + VALIDITY)
    )
    for extension, critical in _extensions(key, name, hosts):
        builder = builder.add_extension(extension, critical)
    return builder.sign(key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)


def _extensions(
    key: rsa.RSAPrivateKey, name: str, hosts: Sequence[str]
) -> list[tuple[x509.ExtensionType, bool]]:
    """Return the extensions that OPC UA (part 6, 6.2.2) and TLS require in a self-signed certificate."""
    own_key = x509.SubjectKeyIdentifier.from_public_key(key.public_key())
    usage = x509.KeyUsage(
        digital_signature=True,
        content_commitment=True,
        key_encipherment=True,
        data_encipherment=True,
        key_agreement=False,
        key_cert_sign=True,
        crl_sign=False,
        encipher_only=False,
        decipher_only=False,
    )
    names = [x509.UniformResourceIdentifier(f"urn:beltsort:{name}"), *map(_general_name, hosts)]
    return [
        (own_key, False),
        (x509.AuthorityKeyIdentifier.from_issuer_subject_key_identifier(own_key), False),
        (x509.BasicConstraints(ca=True, path_length=0), True),
        (usage, True),
        (x509.ExtendedKeyUsage([ExtendedKeyUsageOID.CLIENT_AUTH, ExtendedKeyUsageOID.SERVER_AUTH]), False),
        (x509.SubjectAlternativeName(names), False),
    ]


def _general_name(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ip_address(host))
    except ValueError:
        return x509.DNSName(host)


if __name__ == "__main__":
    arguments = ArgumentParser(
        prog="python -m beltsort.drivers.fieldbus.pki",
        description="Create a key and a self-signed certificate in a folder, unless they exist; print the "
        "certificate's path.",
    )
    arguments.add_argument("folder", type=Path, help="folder, whose name becomes the certificate's")
    arguments.add_argument("hosts", nargs="*", help="names and addresses of a server")
    chosen = arguments.parse_args()
    print(identity(chosen.folder, chosen.hosts).certificate)
