"""The timeouts of the cell file."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from beltsort.cell.commands import TIMEOUT, Act
from beltsort.cell.diverting import BeltReading, DiversionStatus
from beltsort.cell.protocols import Scan
from beltsort.cell.wrappers.layer import (
    AskDiversion,
    DiversionQuery,
    Divert,
    DivertRequest,
    Layer,
    Request,
    ScanRequest,
    Send,
    Take,
)
from beltsort.geometry import Pose


class Deadlines(Layer):
    """Sets the timeout of every command and scan, in place of the caller's.

    Parameters
    ----------
    seconds
        Timeout of each kind of act, seconds.
    scan
        Timeout of a scan, and of a query for the flange's pose, seconds.
    divert
        Timeout of the acknowledgement of a diversion, and of a query to a belt that never stops, seconds.
    """

    def __init__(self, seconds: Mapping[type[Act], float], scan: float, divert: float = TIMEOUT) -> None:
        self._seconds, self._scan, self._divert = seconds, scan, divert

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on with its timeout."""
        return send(replace(request, timeout=self._seconds[type(request.act)]))

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Pass a request for a scan on with its timeout."""
        return take(replace(request, timeout=self._scan))

    def flange_pose(self, ask: Callable[[float], Pose | None], _timeout: float) -> Pose | None:
        """Pass a query for the flange's pose on with the timeout of a scan."""
        return ask(self._scan)

    def reading(self, ask: Callable[[float], BeltReading], _timeout: float) -> BeltReading:
        """Pass a query for a reading of the encoder on with its timeout."""
        return ask(self._divert)

    def divert(self, send: Divert, request: DivertRequest) -> DiversionStatus:
        """Pass a diversion on with its timeout."""
        return send(replace(request, timeout=self._divert))

    def diversion(self, ask: AskDiversion, query: DiversionQuery) -> DiversionStatus:
        """Pass a query for the state of a diversion on with its timeout."""
        return ask(replace(query, timeout=self._divert))
