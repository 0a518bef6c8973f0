"""Messages to a service manager: the protocol of sd_notify(3), without libsystemd."""

import os
import socket
from collections.abc import MutableMapping
from contextlib import suppress
from typing import Self

SOCKET, MICROSECONDS, PROCESS = "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"


class ServiceManager:
    """Tells the service manager that started this process how it is doing; does nothing if there is none.

    Parameters
    ----------
    address
        Path of the manager's socket, an abstract one with `@` in front; None if there is no manager.
    watchdog
        Time without a sign of life after which the manager kills the process, seconds; None if it does not.

    Examples
    --------
    >>> manager = ServiceManager()
    >>> manager.tell("READY=1")
    """

    def __init__(self, address: str | None = None, watchdog: float | None = None) -> None:
        self._address = None if address is None else address.replace("@", "\0", 1)
        self.watchdog = watchdog

    @classmethod
    def of_environment(cls, environment: MutableMapping[str, str] = os.environ) -> Self:
        """Return the manager that the environment names, and remove it there: children have none."""
        address = environment.pop(SOCKET, None)
        microseconds, process = environment.pop(MICROSECONDS, ""), environment.pop(PROCESS, "")
        meant = address is not None and process in ("", str(os.getpid()))
        watched = meant and microseconds.isdecimal() and int(microseconds) > 0
        return cls(address, int(microseconds) / 1e6 if watched else None)

    def tell(self, *lines: str) -> None:
        """Send lines such as `READY=1`; a manager that does not listen is none of this process's business."""
        if self._address is None:
            return
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as to:
            to.setblocking(False)
            to.sendto("\n".join(lines).encode(), self._address)
