"""The timeouts of the cell file."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from beltsort.cell.commands import Act
from beltsort.cell.protocols import Scan
from beltsort.cell.wrappers.layer import Layer, Request, ScanRequest, Send, Take
from beltsort.geometry import Pose


class Deadlines(Layer):
    """Sets the timeout of every command and scan, in place of the caller's.

    Parameters
    ----------
    seconds
        Timeout of each kind of act, seconds.
    scan
        Timeout of a scan, and of a query for the flange's pose, seconds.
    """

    def __init__(self, seconds: Mapping[type[Act], float], scan: float) -> None:
        self._seconds, self._scan = seconds, scan

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on with its timeout."""
        return send(replace(request, timeout=self._seconds[type(request.act)]))

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Pass a request for a scan on with its timeout."""
        return take(replace(request, timeout=self._scan))

    def flange_pose(self, ask: Callable[[float], Pose | None], _timeout: float) -> Pose | None:
        """Pass a query for the flange's pose on with the timeout of a scan."""
        return ask(self._scan)
