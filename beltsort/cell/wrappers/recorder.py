"""A log of device calls, with their times."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from beltsort.cell.commands import Outcome
from beltsort.cell.diverting import BeltReading, DiversionStatus
from beltsort.cell.protocols import Health, Scan
from beltsort.cell.wrappers.layer import (
    METHODS,
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

Result = TypeVar("Result")


@dataclass(frozen=True)
class Call:
    """A call of a device.

    Attributes
    ----------
    name
        The method: `move_to`, `scan`, `advance_to`, `sort`, `health`, `stop`, `outcome_of`,
        `flange_pose`, `position`, `reading`, `divert` or `diversion`.
    target
        Viewpoint, index, label, or the scan's `not_before`; None if the method has none.
    command_id
        The command's id, if the method has one.
    timeout
        Seconds, if the method has one.
    """

    name: str
    target: float | None = None
    command_id: str | None = None
    timeout: float | None = None


@dataclass(frozen=True)
class Recorded:
    """A call that has ended.

    Attributes
    ----------
    device
        The device: `arm`, `camera`, `belt` or `sorter`.
    call
        Method and arguments.
    began
        Start of the call, seconds since the epoch.
    seconds
        Duration of the call, seconds.
    error
        `repr` of the exception that it raised; None if there was none.
    """

    device: str
    call: Call
    began: float
    seconds: float
    error: str | None


class Recorder(Layer):
    """Reports every call when it has ended.

    Parameters
    ----------
    device
        Name of the device.
    tell
        Called with each call; `list.append` for example.
    """

    def __init__(self, device: str, report: Callable[[Recorded], None]) -> None:
        self._device, self._report = device, report

    def command(self, send: Send, request: Request) -> float:
        """Record a command."""
        call = Call(METHODS[type(request.act)], request.act.target, request.command_id, request.timeout)
        return self._recorded(call, lambda: send(request))

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Record a scan."""
        call = Call("scan", target=request.not_before, timeout=request.timeout)
        return self._recorded(call, lambda: take(request))

    def outcome_of(self, ask: Callable[[str], Outcome], command_id: str) -> Outcome:
        """Record a query."""
        return self._recorded(Call("outcome_of", command_id=command_id), lambda: ask(command_id))

    def health(self, ask: Callable[[], Health]) -> Health:
        """Record a query."""
        return self._recorded(Call("health"), ask)

    def stop(self, stop: Callable[[], None]) -> None:
        """Record a stop."""
        self._recorded(Call("stop"), stop)

    def flange_pose(self, ask: Callable[[float], Pose | None], timeout: float) -> Pose | None:
        """Record a query."""
        return self._recorded(Call("flange_pose", timeout=timeout), lambda: ask(timeout))

    def position(self, ask: Callable[[], int | None]) -> int | None:
        """Record a query."""
        return self._recorded(Call("position"), ask)

    def reading(self, ask: Callable[[float], BeltReading], timeout: float) -> BeltReading:
        """Record a query."""
        return self._recorded(Call("reading", timeout=timeout), lambda: ask(timeout))

    def divert(self, send: Divert, request: DivertRequest) -> DiversionStatus:
        """Record a diversion."""
        call = Call("divert", request.label, request.command_id, request.timeout)
        return self._recorded(call, lambda: send(request))

    def diversion(self, ask: AskDiversion, query: DiversionQuery) -> DiversionStatus:
        """Record a query."""
        call = Call("diversion", command_id=query.command_id, timeout=query.timeout)
        return self._recorded(call, lambda: ask(query))

    def _recorded(self, call: Call, act: Callable[[], Result]) -> Result:
        began, start = time.time(), time.perf_counter()
        error: str | None = None
        try:
            return act()
        except BaseException as failure:
            error = repr(failure)
            raise
        finally:
            self._report(Recorded(self._device, call, began, time.perf_counter() - start, error))
