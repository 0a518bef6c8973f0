"""Composition of a cell from the devices of its file."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from beltsort.cell.commands import Act, AdvanceTo, MoveTo, SortInto
from beltsort.cell.protocols import Arm, Belt, DepthCamera, FollowsBelt, KnowsClasses, Sorter
from beltsort.cell.wrappers.bins import Bins
from beltsort.cell.wrappers.camera_poses import CameraPoses
from beltsort.cell.wrappers.deadlines import Deadlines
from beltsort.cell.wrappers.dry_run import DryRun, Say
from beltsort.cell.wrappers.follow import Follow
from beltsort.cell.wrappers.layer import Layer
from beltsort.cell.wrappers.limits import Limits
from beltsort.cell.wrappers.recorder import Recorded, Recorder
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.making import Maker, all_of, backends_of, roles_in_dry_run
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.roles import ROLES
from beltsort.geometry import BeltLayout, Pose
from beltsort.testing.faults import Faults

WRAPPED = {"arm": WrappedArm, "camera": WrappedCamera, "belt": WrappedBelt, "sorter": WrappedSorter}


def nobody_knows(_index: int) -> None:
    """Know the class of no object."""


@dataclass(frozen=True)
class ComposedCell:
    """Arm, camera, belt and sorter of any back-ends: a `Cell`.

    Attributes
    ----------
    arm, camera, belt, sorter
        The devices.
    classes, viewpoints, layout, reject_bin
        As in `Cell`; the index of the reject bin is the number of bins.
    dry_run
        Names of the devices whose commands are printed instead of sent.
    poses
        The camera's pose at each viewpoint in the belt frame, shape (4, 4); None if only joint angles were
        taught, or if the camera does not move.
    bin_numbers, bin_names
        As in `NumbersBins` and `NamesBins` of `beltsort.cell.protocols`.
    true_class
        That of a simulated device, as in `KnowsClasses`; otherwise no class is known.
    """

    arm: Arm
    camera: DepthCamera
    belt: Belt
    sorter: Sorter
    classes: tuple[str, ...]
    viewpoints: tuple[str, ...]
    layout: BeltLayout
    reject_bin: int | None
    dry_run: tuple[str, ...] = ()
    poses: tuple[Pose | None, ...] = ()
    bin_numbers: tuple[int, ...] = ()
    bin_names: tuple[str, ...] = ()
    true_class: Callable[[int], int | None] = nobody_knows


def compose(
    description: CellDescription,
    *,
    live: bool,
    say: Say,
    record: Callable[[Recorded], None] | None = None,
    made: Callable[[Any], None] = lambda _device: None,
) -> ComposedCell:
    """Create the devices that a cell file names, with their wrappers.

    The wrappers of each device, from the outermost: reports of the belt's advances to a simulated camera
    (`Follow`), validation of arguments (`Limits`), the camera's pose in the belt frame (`CameraPoses`), a log
    of calls (`Recorder`), dry run unless `live` (`DryRun`), injected faults (`Faults`), timeouts
    (`Deadlines`), and the bin numbers of a sorter that has them (`Bins`).

    Parameters
    ----------
    description
        The cell file.
    live
        Whether commands are sent to devices that can move hardware. If not, every such arm, belt and sorter
        is in a dry run.
    say
        Called with a line for each command in a dry run.
    record
        Called with every completed call of a device.
    made
        Called with every device that a back-end has created, without wrappers.

    Raises
    ------
    CellFileError
        With all problems of the back-ends and their options, or if the belt never stops: see
        `beltsort.cellfile.composed_moving`.
    """
    if description.moving is not None:
        raise CellFileError.of(
            "moving",
            "is given, expected a belt that stops: only `beltsort run` and "
            "`beltsort check` take one that never stops",
        )
    kinds = backends_of(description)
    maker = Maker(description, made)
    devices = all_of(ROLES, lambda role: maker.device(role, kinds[role]))
    classes = [device.true_class for device in devices.values() if isinstance(device, KnowsClasses)]
    printed = roles_in_dry_run(description, live=live)
    camera_is_still = "arm" in printed or kinds["arm"].absent
    camera = devices["camera"]
    camera_follows = isinstance(camera, FollowsBelt) and camera is not devices["belt"]
    inner = inner_layers(description, numbered=kinds["sorter"].numbered)
    for role in ROLES:
        recorder = [] if record is None else [Recorder(role, record)]
        dry_run = [DryRun(say)] if role in printed else []
        devices[role] = WRAPPED[role](devices[role], *recorder, *dry_run, *inner)
    outer = outer_layers(description, devices["arm"])
    for role in ROLES:
        follow = [Follow(camera)] if camera_follows and role == "belt" else []
        devices[role] = WRAPPED[role](devices[role], *follow, *outer)
    return ComposedCell(
        **devices,
        classes=description.classes,
        viewpoints=description.viewpoint_names,
        layout=description.layout,
        reject_bin=None if description.reject_bin is None else len(description.bin_names),
        bin_names=description.bin_names,
        dry_run=printed,
        poses=tuple(None if camera_is_still else viewpoint.pose() for viewpoint in description.viewpoints),
        bin_numbers=description.bin_numbers,
        true_class=next(iter(classes), nobody_knows),
    )


def outer_layers(description: CellDescription, arm: WrappedArm) -> list[Layer]:
    """Return the wrappers that check arguments and compute the camera's pose, the outermost first."""
    names, poses = description.viewpoint_names, [viewpoint.pose() for viewpoint in description.viewpoints]
    bins = [*description.bin_names, "the reject bin"][: len(description.bin_numbers)]
    camera_poses = CameraPoses(names, poses, description.placement, arm.flange_pose)
    return [Limits(names, bins), camera_poses]


def inner_layers(description: CellDescription, *, numbered: bool) -> list[Layer]:
    """Return the wrappers next to the devices, the outermost first."""
    timeouts = description.timeouts
    seconds: dict[type[Act], float] = {
        MoveTo: timeouts.move, AdvanceTo: timeouts.advance, SortInto: timeouts.sort
    }  # fmt: skip
    faults: list[Layer] = []
    if description.faults is not None:
        faults = [Faults(description.faults.plan(), len(description.viewpoints))]
    bins = [Bins(description.bin_numbers)] if numbered else []
    return [*faults, Deadlines(seconds, timeouts.scan, timeouts.divert), *bins]
