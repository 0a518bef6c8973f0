"""A device whose calls all go through one function."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from beltsort.cell.commands import TIMEOUT, Outcome
from beltsort.cell.protocols import Health, Scan, TellsFlangePose, TellsPosition
from beltsort.geometry import Pose


@dataclass(frozen=True)
class Call:
    """A call of a device.

    Attributes
    ----------
    name
        The method's: `move_to`, `scan`, `advance_to`, `sort`, `health`, `stop`, `outcome_of`,
        `flange_pose` or `position`.
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


Act = Callable[[Call], Any]


class Around(Protocol):
    """What is put around a device."""

    def __call__(self, call: Call, act: Act) -> Any:
        """Do with a call what it likes, and return what the call is to return."""


def chained(arounds: Sequence[Around]) -> Around:
    """Return several as one, the first outermost."""

    def around(call: Call, act: Act) -> Any:
        for inner in reversed(arounds):
            act = partial(inner, act=act)
        return act(call)

    return around


ACTS = ("move_to", "advance_to", "sort")
"""Calls that move something."""
STOPS = ("move_to", "advance_to")
"""Those that return the time of a stop."""


class _Wrapped:
    """What every device can do.

    Parameters
    ----------
    device
        What is wrapped.
    around
        Gets every call.
    """

    def __init__(self, device: Any, around: Around) -> None:
        self._device, self._around = device, around

    def health(self) -> Health:
        """Say how it is."""
        health: Health = self._around(Call("health"), lambda _call: self._device.health())
        return health

    def stop(self) -> None:
        """End every motion now."""
        self._around(Call("stop"), lambda _call: self._device.stop())

    def outcome_of(self, command_id: str, boot_id: str = "", /) -> Outcome:
        """Tell what became of a command."""
        asked = Call("outcome_of", command_id=command_id)
        outcome: Outcome = self._around(asked, lambda call: self._device.outcome_of(call.command_id, boot_id))
        return outcome

    def _command(self, name: str, target: int, command_id: str, timeout: float) -> Any:
        def act(call: Call) -> Any:
            return getattr(self._device, call.name)(call.target, call.command_id, timeout=call.timeout)

        return self._around(Call(name, target, command_id, timeout), act)


class WrappedArm(_Wrapped):
    """An arm."""

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring the camera to `viewpoint`."""
        stopped: float = self._command("move_to", viewpoint, command_id, timeout)
        return stopped

    def flange_pose(self, *, timeout: float = TIMEOUT) -> Pose | None:
        """Return the flange's pose in the robot's world, or None if the arm does not tell it."""
        if not isinstance(self._device, TellsFlangePose):
            return None
        asked = Call("flange_pose", timeout=timeout)
        pose: Pose | None = self._around(asked, lambda call: self._device.flange_pose(timeout=call.timeout))
        return pose


class WrappedBelt(_Wrapped):
    """A belt."""

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring object number `index` to the belt end."""
        stopped: float = self._command("advance_to", index, command_id, timeout)
        return stopped

    def position(self) -> int | None:
        """Return the number of the object at the belt end, `NOWHERE`, or None if the belt does not tell."""
        if not isinstance(self._device, TellsPosition):
            return None
        device = self._device
        position: int | None = self._around(Call("position"), lambda _call: device.position())
        return position


class WrappedSorter(_Wrapped):
    """A sorter."""

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into a bin."""
        self._command("sort", label, command_id, timeout)


class WrappedCamera(_Wrapped):
    """A camera."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan."""
        scan: Scan = self._around(
            Call("scan", target=not_before, timeout=timeout),
            lambda call: self._device.scan(not_before=call.target, timeout=call.timeout),
        )
        return scan
