"""What can stand between a caller and a device."""

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
"""What drivers, faults and records of calls call the acts."""


@dataclass(frozen=True)
class Request:
    """A command on its way to a device.

    Attributes
    ----------
    act
        What is to be done. A layer may change its target, not its kind.
    command_id
        Under which the device acts at most once.
    timeout
        Seconds.
    """

    act: Act
    command_id: str
    timeout: float


@dataclass(frozen=True)
class ScanRequest:
    """A scan that is asked for.

    Attributes
    ----------
    not_before
        When its exposure may begin, seconds on the cell's clock.
    timeout
        Seconds.
    """

    not_before: float
    timeout: float


Send: TypeAlias = Callable[[Request], float]
"""Has a command carried out; returns the time of the stop, seconds on the cell's clock; 0 for a sort."""
Take: TypeAlias = Callable[[ScanRequest], Scan]


class Layer:
    """Stands between a caller and a device. This one passes every call on; others override what they change.

    Every method gets what passes the call on, to the next layer and at last to the device, and then what was
    asked. It returns what the caller gets.
    """

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on."""
        return send(request)

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Pass on that a scan is to be taken."""
        return take(request)

    def outcome_of(self, ask: Callable[[str], Outcome], command_id: str) -> Outcome:
        """Pass on the question what became of a command."""
        return ask(command_id)

    def health(self, ask: Callable[[], Health]) -> Health:
        """Pass on the question how the device is."""
        return ask()

    def stop(self, stop: Callable[[], None]) -> None:
        """Pass on that every motion is to end."""
        stop()

    def flange_pose(self, ask: Callable[[float], Pose | None], timeout: float) -> Pose | None:
        """Pass on the question where the arm's flange is."""
        return ask(timeout)

    def position(self, ask: Callable[[], int | None]) -> int | None:
        """Pass on the question where the belt stands."""
        return ask()


def through(
    layers: Sequence[Layer],
    method: Callable[[Layer], Callable[Concatenate[Callable[Asked, Result], Asked], Result]],
    device: Callable[Asked, Result],
) -> Callable[Asked, Result]:
    """Return a call of a device that goes through layers, the first outermost.

    Parameters
    ----------
    layers
        Around the device.
    method
        Which of a layer's methods gets the call.
    device
        The device's own.
    """
    call = device
    for layer in reversed(layers):
        call = partial(method(layer), call)
    return call
