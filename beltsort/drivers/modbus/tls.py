"""Mutual TLS: each side has a certificate that the other trusts."""

import ssl
from pathlib import Path

from beltsort.drivers.fieldbus.security import trusted


def context(protocol: int, certificate: str, private_key: str, trust: str) -> ssl.SSLContext:
    """Return a context for one side, `ssl.PROTOCOL_TLS_CLIENT` or `ssl.PROTOCOL_TLS_SERVER`.

    Parameters
    ----------
    certificate, private_key
        PEM files of this side.
    trust
        Folder of trusted certificates, .pem or .der: the other side's own, or that of its issuer.
    """
    made = ssl.SSLContext(protocol)
    made.minimum_version = ssl.TLSVersion.TLSv1_2
    made.verify_mode = ssl.CERT_REQUIRED
    made.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN  # a certificate in the folder need not be a root
    made.load_cert_chain(certificate, private_key)
    for path in trusted(Path(trust)):
        if path.suffix == ".pem":
            made.load_verify_locations(cafile=path)
        else:
            made.load_verify_locations(cadata=path.read_bytes())
    return made
