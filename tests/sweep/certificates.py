"""An authority and one certificate signed by it, made for a test."""

import os
import subprocess
from pathlib import Path

from beltsort.sweep.cluster import Certificates


def make_certificates(folder: Path) -> Certificates:
    authority, authority_key = folder / "ca.pem", folder / "ca.key"
    request, certificate, key = folder / "client.csr", folder / "client.pem", folder / "client.key"
    previous = os.umask(0o077)
    try:
        new = ("req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
        _openssl(*new, "-x509", "-subj", "/CN=authority", "-keyout", authority_key, "-out", authority)
        _openssl(*new, "-subj", "/CN=beltsort", "-keyout", key, "-out", request)
        signing = ("-CA", authority, "-CAkey", authority_key, "-CAcreateserial")
        _openssl("x509", "-req", "-in", request, *signing, "-out", certificate)
    finally:
        os.umask(previous)
    return Certificates(authority, certificate, key)


def _openssl(*arguments: str | Path) -> None:
    command = ["openssl", *map(str, arguments)]
    subprocess.run(command, check=True, capture_output=True)
