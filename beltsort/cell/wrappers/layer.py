"""The base class of wrappers: layers between a caller and a device."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Concatenate, ParamSpec, TypeAlias, TypeVar

from beltsort.cell.commands import Act, AdvanceTo, MoveTo, Outcome, SortInto
from beltsort.cell.diverting import BeltReading, DiversionStatus
from beltsort.cell.protocols import Health, Scan
from beltsort.geometry import Pose

Asked = ParamSpec("Asked")
Result = TypeVar("Result")

METHODS: dict[type[Act], str] = {MoveTo: "move_to", AdvanceTo: "advance_to", SortInto: "sort"}
"""The device's method for each act."""


@dataclass(frozen=True)
class Request:
    """A command on its way to a device.

    Attributes
    ----------
    act
        The motion or sort. A layer may change its target, but not its kind.
    command_id
        The device executes it at most once.
    timeout
        Timeout, seconds.
    """

    act: Act
    command_id: str
    timeout: float


@dataclass(frozen=True)
class ScanRequest:
    """A request for a scan.

    Attributes
    ----------
    not_before
        Earliest start of the exposure, seconds on the cell's clock.
    timeout
        Timeout, seconds.
    """

    not_before: float
    timeout: float


@dataclass(frozen=True)
class DivertRequest:
    """A diversion on its way to a belt.

    Attributes
    ----------
    command_id
        The belt queues it at most once.
    number
        Number of the object.
    coordinate
        The object's, metres.
    label
        Index of the bin, or the belt's number of it.
    boot_id
        That for which the coordinate holds.
    timeout
        Timeout, seconds.
    """

    command_id: str
    number: int
    coordinate: float
    label: int
    boot_id: str
    timeout: float


@dataclass(frozen=True)
class DiversionQuery:
    """A question about a diversion.

    Attributes
    ----------
    command_id, boot_id
        Those with which it was sent.
    timeout
        Timeout, seconds.
    """

    command_id: str
    boot_id: str
    timeout: float


Send: TypeAlias = Callable[[Request], float]
"""Executes a command; returns the time of the stop, seconds on the cell's clock, or 0 for a sort."""
Take: TypeAlias = Callable[[ScanRequest], Scan]
"""Takes a scan."""
Divert: TypeAlias = Callable[[DivertRequest], DiversionStatus]
"""Queues a diversion."""
AskDiversion: TypeAlias = Callable[[DiversionQuery], DiversionStatus]
"""Returns the state of a diversion."""


class Layer:
    """A layer between a caller and a device. This one passes every call on; subclasses override methods.

    The first argument of each method is a function that passes the call on to the next layer or the device;
    the others are those of the call. The method returns the result for the caller.
    """

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on."""
        return send(request)

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Pass a request for a scan on."""
        return take(request)

    def outcome_of(self, ask: Callable[[str], Outcome], command_id: str) -> Outcome:
        """Pass a query for the outcome of a command on."""
        return ask(command_id)

    def health(self, ask: Callable[[], Health]) -> Health:
        """Pass a query for the device's health on."""
        return ask()

    def stop(self, stop: Callable[[], None]) -> None:
        """Pass a stop on."""
        stop()

    def flange_pose(self, ask: Callable[[float], Pose | None], timeout: float) -> Pose | None:
        """Pass a query for the pose of the arm's flange on."""
        return ask(timeout)

    def position(self, ask: Callable[[], int | None]) -> int | None:
        """Pass a query for the belt's position on."""
        return ask()

    def reading(self, ask: Callable[[float], BeltReading], timeout: float) -> BeltReading:
        """Pass a query for a reading of the belt's encoder on."""
        return ask(timeout)

    def divert(self, send: Divert, request: DivertRequest) -> DiversionStatus:
        """Pass a diversion on."""
        return send(request)

    def diversion(self, ask: AskDiversion, query: DiversionQuery) -> DiversionStatus:
        """Pass a query for the state of a diversion on."""
        return ask(query)


def through(
    layers: Sequence[Layer],
    method: Callable[[Layer], Callable[Concatenate[Callable[Asked, Result], Asked], Result]],
    device: Callable[Asked, Result],
) -> Callable[Asked, Result]:
    """Return a function that calls a device's method through layers.

    Parameters
    ----------
    layers
        The layers around the device, the outermost first.
    method
        Selects the method of a layer that receives the call.
    device
        The device's method.
    """
    call = device
    for layer in reversed(layers):
        call = partial(method(layer), call)
    return call
