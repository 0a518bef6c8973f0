"""The back-end `dry-run`: placeholders with which a cell file can be tried without hardware.

Arm, belt and sorter log their commands; the camera returns scans of a level, empty belt. A belt that never
stops moves with the speed of [moving]; since the camera sees no cup on it, a run waits for the first one.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from beltsort.cell.diverting import BeltReading
from beltsort.cell.placement import Placement
from beltsort.cell.protocols import Health, Scan
from beltsort.cell.wrappers.dry_run import DryRun
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedDivertingBelt, WrappedSorter
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.registry import Backend, backend_of
from beltsort.geometry import Pose, look_at
from beltsort.sim.sensor import Camera

log = logging.getLogger(__name__)

PINHOLE = Camera(width=160, height=120, focal=142.5)
OVERHEAD = look_at(np.array([0.0, 0.0, 0.7]), np.zeros(3))


@dataclass(frozen=True)
class NoOptions:
    """The back-end `dry-run` has no options."""


class Absent:
    """A device that is always ready and does nothing."""

    def health(self) -> Health:
        """Return that the device is ready."""
        return Health(ready=True, boot_id="dry-run")

    def stop(self) -> None:
        """Do nothing: nothing moves."""


class AbsentMovingBelt(Absent):
    """A belt that moves with a constant speed, without an encoder.

    Parameters
    ----------
    speed
        Metres per second.
    """

    def __init__(self, speed: float) -> None:
        self._speed, self._began = speed, time.monotonic()

    def reading(self, **_timeout: float) -> BeltReading:
        """Return how far the belt has moved."""
        now = time.monotonic()
        return BeltReading(now, self._speed * (now - self._began), "dry-run")


class EmptyBeltCamera(Absent):
    """A camera that returns scans of a level, empty belt.

    Parameters
    ----------
    belt_from_camera
        The camera's fixed pose in the belt frame, shape (4, 4).
    placement
        Transform from the belt frame to the robot's world frame.
    """

    def __init__(self, belt_from_camera: Pose, placement: Placement | None = None) -> None:
        self._pose, self._placement = belt_from_camera, placement or Placement()

    def scan(self, *, not_before: float, **_timeout: float) -> Scan:
        """Return a scan of the belt's plane."""
        rays = PINHOLE.deproject(np.ones((PINHOLE.height, PINHOLE.width))) @ self._pose[:3, :3].T
        with np.errstate(divide="ignore"):
            depth = -self._pose[2, 3] / rays[..., 2]
        depth[(depth <= 0.0) | (depth > 5.0)] = np.nan
        stamp = max(not_before, time.monotonic())
        return Scan(PINHOLE.deproject(depth), self._placement.in_world(self._pose), stamp)


def _camera(_options: NoOptions, cell: CellDescription) -> EmptyBeltCamera:
    pose = cell.viewpoints[0].pose()
    return EmptyBeltCamera(OVERHEAD if pose is None else pose, cell.placement)


def _mover(kind: Callable[[Any, DryRun], object]) -> Backend:
    """Return the back-end of a device that has no commands of its own: `DryRun` passes none on."""
    return backend_of(
        NoOptions, lambda _options, _cell: kind(Absent(), DryRun(log.info)), harmless=True, absent=True
    )


ARM, BELT, SORTER = _mover(WrappedArm), _mover(WrappedBelt), _mover(WrappedSorter)


def _diverter(_options: NoOptions, cell: CellDescription) -> WrappedDivertingBelt:
    speed = 0.0 if cell.moving is None else cell.moving.speed(cell.belt.spacing)
    belt: Any = AbsentMovingBelt(speed)  # its diversions are `DryRun`'s
    return WrappedDivertingBelt(belt, DryRun(log.info))


DIVERTER = backend_of(NoOptions, _diverter, harmless=True, absent=True)
CAMERA = backend_of(NoOptions, _camera, harmless=True)
