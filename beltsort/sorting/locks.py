"""One run, one process; one live device, one run."""

import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from beltsort.cell.protocols import Addressed
from beltsort.errors import InUseError

DEVICES = Path(tempfile.gettempdir()) / "beltsort-devices"
"""Folder of the locks of devices: one for all users of this machine."""


LOCK_TIMEOUT = 0.2
"""Time for which a lock is tried, seconds: longer than `in_use` holds one."""


@dataclass(frozen=True)
class Holder:
    """The process that holds a lock."""

    pid: int
    command: str


@contextmanager
def locked(what: str, path: Path) -> Iterator[None]:
    """Hold a lock as long as the block runs; the system releases it when the process ends, however it ends.

    Parameters
    ----------
    what
        Names what is locked in the error.
    path
        Of the lock; who holds it is written beside it.

    Raises
    ------
    InUseError
        If another process holds it, with that process's id.
    """
    from filelock import FileLock, Timeout  # here, as commands that plan do without it

    holder = _holder_file(path)
    lock = FileLock(path, timeout=LOCK_TIMEOUT, mode=0o666)
    try:
        lock.acquire()
    except Timeout:
        raise InUseError(
            f"{what} is in use by {_name_of(path)}, expected nobody: wait until that ends, or end it (kill)"
        ) from None
    except OSError as reason:
        raise InUseError(f"{what} cannot be locked: {reason}; make {path.parent} writable") from reason
    try:
        holder.write_text(json.dumps(asdict(Holder(os.getpid(), " ".join(sys.argv)))))
        yield
    finally:
        lock.release()


@contextmanager
def devices_locked(devices: Iterable[object]) -> Iterator[None]:
    """Hold the locks of those devices that have an address as long as the block runs.

    Raises
    ------
    InUseError
        If another process drives one of them.
    """
    try:
        DEVICES.mkdir(exist_ok=True)
        if DEVICES.stat().st_uid == os.getuid():
            DEVICES.chmod(0o1777)
    except OSError as reason:
        raise InUseError(f"devices cannot be locked: {reason}; make {DEVICES} writable") from reason
    with ExitStack() as stack:
        addresses = {device.address for device in devices if isinstance(device, Addressed)}
        for address in sorted(addresses):
            name = hashlib.sha256(address.encode()).hexdigest()[:16]
            stack.enter_context(locked(f"the device at {address}", DEVICES / f"{name}.lock"))
        yield


def in_use(path: Path) -> bool:
    """Whether a process holds a lock. Nothing is written, and the lock is free again when this returns."""
    import fcntl  # here, as there is none on Windows, where planning works

    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False


def holder_of(path: Path) -> Holder | None:
    """Return the process that holds a lock, or held it last; None if it is not known."""
    try:
        return Holder(**json.loads(_holder_file(path).read_text()))
    except (OSError, ValueError, TypeError):
        return None


def _holder_file(path: Path) -> Path:
    return path.with_name(f"{path.name}.holder")


def _name_of(path: Path) -> str:
    """Say who holds a lock."""
    holder = holder_of(path)
    return "another process" if holder is None else f"process {holder.pid} ({holder.command})"
