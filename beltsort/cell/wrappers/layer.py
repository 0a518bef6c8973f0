"""The base class of wrappers: layers between a caller and a device."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Concatenate, ParamSpec, TypeAlias, TypeVar

from beltsort.cell.commands import Act, AdvanceTo, MoveTo, Outcome, SortInto
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


Send: TypeAlias = Callable[[Request], float]
"""Executes a command; returns the time of the stop, seconds on the cell's clock, or 0 for a sort."""
Take: TypeAlias = Callable[[ScanRequest], Scan]
"""Takes a scan."""


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
