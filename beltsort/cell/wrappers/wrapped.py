"""Devices wrapped in layers."""

from typing import Generic, TypeVar

from beltsort.cell.commands import TIMEOUT, Act, AdvanceTo, MoveTo, Outcome, SortInto
from beltsort.cell.diverting import BeltReading, DiversionStatus, DivertingBelt
from beltsort.cell.protocols import (
    Actuator,
    Arm,
    Belt,
    DepthCamera,
    Device,
    Health,
    Scan,
    Sorter,
    TellsFlangePose,
    TellsPosition,
)
from beltsort.cell.wrappers.layer import (
    DiversionQuery,
    DivertRequest,
    Layer,
    Request,
    ScanRequest,
    Send,
    through,
)
from beltsort.geometry import Pose

AnyDevice = TypeVar("AnyDevice", bound=Device)
AnyActuator = TypeVar("AnyActuator", bound=Actuator)


class _Wrapped(Generic[AnyDevice]):
    """A wrapped device.

    Parameters
    ----------
    device
        The device.
    *layers
        The layers around it, the outermost first.
    """

    def __init__(self, device: AnyDevice, *layers: Layer) -> None:
        self._device, self._layers = device, layers

    def health(self) -> Health:
        """Return the device's health."""
        return through(self._layers, lambda layer: layer.health, self._device.health)()

    def stop(self) -> None:
        """Stop every motion now."""
        through(self._layers, lambda layer: layer.stop, self._device.stop)()


class _WrappedActuator(_Wrapped[AnyActuator]):
    """A wrapped actuator."""

    def outcome_of(self, command_id: str, boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command."""

        def ask(known_as: str, /) -> Outcome:
            return self._device.outcome_of(known_as, boot_id)

        return through(self._layers, lambda layer: layer.outcome_of, ask)(command_id)

    def _command(self, device: Send, act: Act, command_id: str, timeout: float) -> float:
        request = Request(act, command_id, timeout)
        return through(self._layers, lambda layer: layer.command, device)(request)


class WrappedArm(_WrappedActuator[Arm]):
    """A wrapped arm."""

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Move the camera to `viewpoint`."""

        def move(request: Request) -> float:
            return self._device.move_to(request.act.target, request.command_id, timeout=request.timeout)

        return self._command(move, MoveTo(viewpoint), command_id, timeout)

    def flange_pose(self, *, timeout: float = TIMEOUT) -> Pose | None:
        """Return the flange's pose in the robot's world frame, or None if the arm does not report it."""
        arm = self._device
        if not isinstance(arm, TellsFlangePose):
            return None

        def ask(seconds: float, /) -> Pose | None:
            return arm.flange_pose(timeout=seconds)

        return through(self._layers, lambda layer: layer.flange_pose, ask)(timeout)


class WrappedBelt(_WrappedActuator[Belt]):
    """A wrapped belt."""

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Advance the belt until object `index` is at its end."""

        def advance(request: Request) -> float:
            return self._device.advance_to(request.act.target, request.command_id, timeout=request.timeout)

        return self._command(advance, AdvanceTo(index), command_id, timeout)

    def position(self) -> int | None:
        """Return the number of the object at the belt end, `NOWHERE`, or None if it is not reported."""
        if not isinstance(self._device, TellsPosition):
            return None
        return through(self._layers, lambda layer: layer.position, self._device.position)()


class WrappedDivertingBelt(_Wrapped[DivertingBelt]):
    """A wrapped belt that never stops."""

    def reading(self, *, timeout: float = TIMEOUT) -> BeltReading:
        """Return a reading of the encoder."""

        def ask(seconds: float, /) -> BeltReading:
            return self._device.reading(timeout=seconds)

        return through(self._layers, lambda layer: layer.reading, ask)(timeout)

    def divert(
        self,
        command_id: str,
        *,
        number: int,
        coordinate: float,
        label: int,
        boot_id: str,
        timeout: float = TIMEOUT,
    ) -> DiversionStatus:
        """Queue a diversion."""

        def divert(request: DivertRequest) -> DiversionStatus:
            return self._device.divert(
                request.command_id,
                number=request.number,
                coordinate=request.coordinate,
                label=request.label,
                boot_id=request.boot_id,
                timeout=request.timeout,
            )

        request = DivertRequest(command_id, number, coordinate, label, boot_id, timeout)
        return through(self._layers, lambda layer: layer.divert, divert)(request)

    def diversion(self, command_id: str, *, boot_id: str, timeout: float = TIMEOUT) -> DiversionStatus:
        """Return the state of a diversion."""

        def ask(query: DiversionQuery) -> DiversionStatus:
            return self._device.diversion(query.command_id, boot_id=query.boot_id, timeout=query.timeout)

        query = DiversionQuery(command_id, boot_id, timeout)
        return through(self._layers, lambda layer: layer.diversion, ask)(query)


class WrappedSorter(_WrappedActuator[Sorter]):
    """A wrapped sorter."""

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into a bin."""

        def sort(request: Request) -> float:
            self._device.sort(request.act.target, request.command_id, timeout=request.timeout)
            return 0.0

        self._command(sort, SortInto(label), command_id, timeout)


class WrappedCamera(_Wrapped[DepthCamera]):
    """A wrapped camera."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan."""

        def take(request: ScanRequest) -> Scan:
            return self._device.scan(not_before=request.not_before, timeout=request.timeout)

        return through(self._layers, lambda layer: layer.scan, take)(ScanRequest(not_before, timeout))
