"""Security of connections to a controller: trusted certificates, and the exception for this computer."""

from ipaddress import ip_address
from pathlib import Path

from beltsort.errors import CellError


def check_loopback(host: str) -> None:
    """Check that an insecure connection stays on this computer.

    Raises
    ------
    CellError
        If `host` is neither "localhost" nor a loopback address.
    """
    try:
        loopback = host == "localhost" or ip_address(host).is_loopback
    except ValueError:  # another name
        loopback = False
    if not loopback:
        raise CellError(
            f"host is {host!r} without security, expected this computer (127.0.0.1); give certificates"
        )


def trusted(folder: Path) -> list[Path]:
    """Return the certificates in a folder, .pem and .der files, sorted by name.

    Raises
    ------
    CellError
        If there are none.
    """
    files = sorted(path for path in folder.glob("*") if path.suffix in (".pem", ".der"))
    if not files:
        raise CellError(
            f"{folder} contains no certificate, expected at least one .pem or .der file; copy the other "
            "side's there"
        )
    return files
