"""Composition of a cell whose belt never stops from the devices of its file."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from beltsort.cell.diverting import DivertingBelt, KnowsClassesAt
from beltsort.cell.protocols import Arm, DepthCamera
from beltsort.cell.wrappers.dry_run import DryRun, Say
from beltsort.cell.wrappers.follow_travel import FollowsTravel, FollowTravel
from beltsort.cell.wrappers.recorder import Recorded, Recorder
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedCamera, WrappedDivertingBelt
from beltsort.cellfile.composed import inner_layers, outer_layers
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.making import Maker, all_of, backends_of, roles_in_dry_run
from beltsort.cellfile.roles import DIVERTER, MOVING_ROLES, TABLES
from beltsort.geometry import BeltLayout, Pose

WRAPPED = {"arm": WrappedArm, "camera": WrappedCamera, DIVERTER: WrappedDivertingBelt}


@runtime_checkable
class KeepsTime(Protocol):
    """A simulated world with a clock of its own."""

    def wait(self, seconds: float) -> None:
        """Let time pass."""


def class_not_known(_coordinate: float) -> None:
    """Know the class of no object."""


@dataclass(frozen=True)
class ComposedMovingCell:
    """Arm, camera and belt of any back-ends: a `DivertingCell`.

    Attributes
    ----------
    arm, camera, belt
        The devices.
    classes, viewpoints, layout
        As in `DivertingCell`.
    dry_run
        Names of the devices whose commands are printed instead of sent.
    poses
        The camera's pose at each viewpoint in the belt frame, shape (4, 4); None if only joint angles were
        taught, or if the camera does not move.
    bin_numbers, bin_names
        As in `NumbersBins` and `NamesBins` of `beltsort.cell.protocols`.
    wait
        Lets time pass: that of a simulated world, or real time.
    true_class_at
        That of a simulated device, as in `KnowsClassesAt`; otherwise no class is known.
    """

    arm: Arm
    camera: DepthCamera
    belt: DivertingBelt
    classes: tuple[str, ...]
    viewpoints: tuple[str, ...]
    layout: BeltLayout
    dry_run: tuple[str, ...] = ()
    poses: tuple[Pose | None, ...] = ()
    bin_numbers: tuple[int, ...] = ()
    bin_names: tuple[str, ...] = ()
    wait: Callable[[float], None] = time.sleep
    true_class_at: Callable[[float], int | None] = class_not_known


def compose_moving(
    description: CellDescription,
    *,
    live: bool,
    say: Say,
    record: Callable[[Recorded], None] | None = None,
    made: Callable[[Any], None] = lambda _device: None,
) -> ComposedMovingCell:
    """Create the devices of a cell file with [moving], with their wrappers.

    The wrappers are those of `beltsort.cellfile.composed.compose`, but for those that only a belt that stops
    needs; a simulated camera over another belt gets the readings of its encoder (`FollowTravel`).

    Parameters
    ----------
    description
        The cell file.
    live
        Whether commands are sent to devices that can move hardware. If not, such an arm or belt is in a dry
        run.
    say
        Called with a line for each command in a dry run.
    record
        Called with every completed call of a device.
    made
        Called with every device that a back-end has created, without wrappers.

    Raises
    ------
    CellFileError
        With all problems of the back-ends and their options.
    """
    kinds = backends_of(description)
    maker = Maker(description, made)
    devices = all_of(MOVING_ROLES, lambda role: maker.device(role, kinds[role]))
    bare = list(devices.values())
    printed = roles_in_dry_run(description, live=live)
    camera_is_still = "arm" in printed or kinds["arm"].absent
    inner = inner_layers(description, numbered=kinds[DIVERTER].numbered)
    for role in MOVING_ROLES:
        recorder = [] if record is None else [Recorder(TABLES[role], record)]
        dry_run = [DryRun(say)] if TABLES[role] in printed else []
        devices[role] = WRAPPED[role](devices[role], *recorder, *dry_run, *inner)
    outer = outer_layers(description, devices["arm"])
    arm, camera = (WRAPPED[role](devices[role], *outer) for role in ("arm", "camera"))
    follow = [FollowTravel(device) for device in bare[1:2] if isinstance(device, FollowsTravel)]
    belt = WrappedDivertingBelt(devices[DIVERTER], *follow, *outer)
    waits = [device.wait for device in bare if isinstance(device, KeepsTime)]
    classes = [device.true_class_at for device in bare if isinstance(device, KnowsClassesAt)]
    return ComposedMovingCell(
        arm,
        camera,
        belt,
        classes=description.classes,
        viewpoints=description.viewpoint_names,
        layout=description.layout,
        dry_run=printed,
        poses=tuple(None if camera_is_still else viewpoint.pose() for viewpoint in description.viewpoints),
        bin_numbers=description.bin_numbers,
        bin_names=description.bin_names,
        wait=next(iter(waits), time.sleep),
        true_class_at=next(iter(classes), class_not_known),
    )
