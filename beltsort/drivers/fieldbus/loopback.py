"""Without security only on this computer."""

from ipaddress import ip_address

from beltsort.errors import CellError


def check_loopback(host: str) -> None:
    """Refuse to do without security beyond this computer.

    Raises
    ------
    CellError
        If `host` is neither "localhost" nor a loopback address.
    """
    if host != "localhost" and not (_is_address(host) and ip_address(host).is_loopback):
        raise CellError(
            f"host is {host!r} without security, expected this computer (127.0.0.1); give certificates"
        )


def _is_address(host: str) -> bool:
    try:
        ip_address(host)
    except ValueError:
        return False
    return True
