"""Every command gets the time that the cell file grants it."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from beltsort.cell.commands import Act
from beltsort.cell.protocols import Scan
from beltsort.cell.wrappers.layer import Layer, Request, ScanRequest, Send, Take
from beltsort.geometry import Pose


class Deadlines(Layer):
    """Gives commands their timeouts, whatever the caller says.

    Parameters
    ----------
    seconds
        By kind of act.
    scan
        Of a scan, and of the question where the flange was when it was taken, seconds.
    """

    def __init__(self, seconds: Mapping[type[Act], float], scan: float) -> None:
        self._seconds, self._scan = seconds, scan

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on with its timeout."""
        return send(replace(request, timeout=self._seconds[type(request.act)]))

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Have a scan taken in its time."""
        return take(replace(request, timeout=self._scan))

    def flange_pose(self, ask: Callable[[float], Pose | None], _timeout: float) -> Pose | None:
        """Ask where the flange is, as long as a scan may take."""
        return ask(self._scan)
