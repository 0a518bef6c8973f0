"""Points run on a Dask cluster (extra `cluster`).

Scheduler and workers exchange Python objects and run what they are sent: whoever can talk to them can run
anything. So the address of another machine is used only with TLS and certificates on both sides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from beltsort.errors import SweepError
from beltsort.sweep.engine import Attempt, Attempts, Point
from beltsort.util.extras import require

if TYPE_CHECKING:
    from distributed import Client, Future

CONNECTING = 10.0  # seconds
WORKERS = 30.0  # seconds


@dataclass(frozen=True)
class Certificates:
    """Files (PEM) for mutual authentication.

    Attributes
    ----------
    authority
        Certificate of the authority that signed the scheduler's and the workers' certificates.
    certificate, key
        This client's own, signed by the same authority.
    """

    authority: Path
    certificate: Path
    key: Path

    def __post_init__(self) -> None:
        """Refuse files that are not there."""
        for file in (self.authority, self.certificate, self.key):
            if not file.is_file():
                raise SweepError(f"there is no file {file}; name a certificate or key (PEM)")


class Cluster:
    """A Dask scheduler and its workers; each needs the same beltsort, and the files that points name.

    A worker that is lost loses only what it was running: the scheduler gives that to another one.

    Parameters
    ----------
    address
        `HOST:PORT`, `tcp://HOST:PORT` or `tls://HOST:PORT`.
    certificates
        Needed for `tls://`.

    Raises
    ------
    SweepError
        If the address is invalid or is another machine's without TLS, if certificates are missing or given
        without TLS, or if Dask is not installed; when points are run, if no scheduler answers or it has no
        workers.
    """

    def __init__(self, address: str, certificates: Certificates | None = None) -> None:
        self.address = address if "://" in address else f"tcp://{address}"
        self.certificates = certificates
        _check_address(self.address, certificates)
        require("cluster", "distributed")

    def attempts(self, trial: Callable[[Point], Attempt], points: Sequence[Point]) -> Attempts:
        """Yield the number and the result of each point, as soon as it is done."""
        if not points:
            return
        from distributed import as_completed

        client = self._client()
        try:
            futures = client.map(trial, points, pure=False)
            numbers = {future.key: number for number, future in enumerate(futures)}
            finished = as_completed(futures, loop=client.loop)
            del futures  # a future that nobody holds frees its result
            for future in finished:
                yield numbers[future.key], _result(future)
        finally:
            client.close()

    def _client(self) -> "Client":
        """Connect, and wait for the first worker."""
        from distributed import Client

        try:
            client = Client(self.address, security=self._security(), timeout=CONNECTING, set_as_default=False)
        except (OSError, ValueError, RuntimeError) as reason:
            raise SweepError(
                f"no scheduler answers at {self.address}: {reason}; start one (`dask scheduler`) or correct "
                "--scheduler"
            ) from reason
        try:
            client.wait_for_workers(1, timeout=WORKERS)
        except OSError as reason:
            client.close()
            raise SweepError(
                f"the scheduler at {self.address} has had no worker for {WORKERS:g} s; start some "
                f"(`dask worker {self.address}`)"
            ) from reason
        return client

    def _security(self) -> Any:
        if self.certificates is None:
            return None
        from distributed.security import Security

        return Security(
            require_encryption=True,
            tls_ca_file=str(self.certificates.authority),
            tls_client_cert=str(self.certificates.certificate),
            tls_client_key=str(self.certificates.key),
        )


def _result(future: "Future") -> Attempt:
    """Return the result of a point; a failure of the cluster counts as a failure of the point."""
    try:
        attempt: Attempt = future.result()
    except Exception as error:
        return Attempt(None, f"on the cluster: {type(error).__name__}: {error}")
    return attempt


def _check_address(address: str, certificates: Certificates | None) -> None:
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if host is None or port is None or parts.scheme not in ("tcp", "tls"):
        raise SweepError(f"--scheduler {address}: expected tcp://HOST:PORT or tls://HOST:PORT")
    if parts.scheme == "tls" and certificates is None:
        raise SweepError(f"--scheduler {address}: give --tls-ca, --tls-cert and --tls-key, files (PEM)")
    if parts.scheme == "tcp" and certificates is not None:
        raise SweepError(f"--scheduler {address}: certificates mean nothing to tcp://; write tls://")
    if parts.scheme == "tcp" and not _is_loopback(host):
        raise SweepError(
            f"--scheduler {address}: {host} is not this machine, and without TLS anyone on the network could "
            "run programs as you; write tls:// and give --tls-ca, --tls-cert and --tls-key"
        )


def _is_loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
