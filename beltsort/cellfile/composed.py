"""Composition of a cell from the devices of its file."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
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
from beltsort.cellfile.problems import CellFileError, raise_all
from beltsort.cellfile.registry import ROLES, Backend, backend
from beltsort.geometry import BeltLayout, Pose
from beltsort.testing.faults import Faults

WRAPPED = {"arm": WrappedArm, "camera": WrappedCamera, "belt": WrappedBelt, "sorter": WrappedSorter}
MOVERS = ("arm", "belt", "sorter")


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
        With all problems of the back-ends and their options.
    """
    kinds = _all_of(lambda role: backend(role, description.device(role).backend))
    maker = _Maker(description, made)
    devices = _all_of(lambda role: maker.device(role, kinds[role]))
    classes = [device.true_class for device in devices.values() if isinstance(device, KnowsClasses)]
    printed = roles_in_dry_run(description, live=live)
    camera_is_still = "arm" in printed or kinds["arm"].absent
    camera = devices["camera"]
    camera_follows = isinstance(camera, FollowsBelt) and camera is not devices["belt"]
    inner = _inner_layers(description, numbered=kinds["sorter"].numbered)
    for role in ROLES:
        recorder = [] if record is None else [Recorder(role, record)]
        dry_run = [DryRun(say)] if role in printed else []
        devices[role] = WRAPPED[role](devices[role], *recorder, *dry_run, *inner)
    outer = _outer_layers(description, devices["arm"])
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


def roles_in_dry_run(description: CellDescription, *, live: bool) -> tuple[str, ...]:
    """Return the names of the devices whose commands are printed instead of sent.

    Raises
    ------
    CellFileError
        If there is no such back-end.
    """
    if live:
        return ()
    return tuple(role for role in MOVERS if not backend(role, description.device(role).backend).harmless)


@dataclass
class _Maker:
    """Creates the devices of a cell; one that several roles share is created once."""

    description: CellDescription
    on_made: Callable[[Any], None]
    made: list[tuple[Backend, Mapping[str, object], Any]] = field(default_factory=list)

    def device(self, role: str, kind: Backend) -> Any:
        """Return the device of a role; one with the same options is shared if the back-end says so."""
        options = self.description.options_of(role)
        for same_kind, same_options, device in self.made:
            if kind.shared and (same_kind, same_options) == (kind, options):
                return device
        try:
            device = kind.make(options, self.description)
        except CellFileError as error:
            raise error.below(lambda key: self._table_of(role, key)) from None
        self.made.append((kind, options, device))
        self.on_made(device)
        return device

    def _table_of(self, role: str, key: str) -> str:
        """Return the table of the cell file that contains an option, or to which a missing one belongs."""
        name = self.description.device(role).backend
        shared = self.description.backends.get(name, {})
        return f"backends.{name}" if not key or re.split(r"[.[]", key)[0] in shared else f"{role}.options"


def _all_of(make: Callable[[str], Any]) -> dict[str, Any]:
    """Return the result of `make` for each role, or raise one error with the problems of all roles."""
    made, errors = {}, []
    for role in ROLES:
        try:
            made[role] = make(role)
        except CellFileError as error:
            errors.append(error)
    raise_all(errors)
    return made


def _outer_layers(description: CellDescription, arm: WrappedArm) -> list[Layer]:
    """Return the wrappers that check arguments and compute the camera's pose, the outermost first."""
    names, poses = description.viewpoint_names, [viewpoint.pose() for viewpoint in description.viewpoints]
    bins = [*description.bin_names, "the reject bin"][: len(description.bin_numbers)]
    camera_poses = CameraPoses(names, poses, description.placement, arm.flange_pose)
    return [Limits(names, bins), camera_poses]


def _inner_layers(description: CellDescription, *, numbered: bool) -> list[Layer]:
    """Return the wrappers next to the devices, the outermost first."""
    timeouts = description.timeouts
    seconds: dict[type[Act], float] = {
        MoveTo: timeouts.move, AdvanceTo: timeouts.advance, SortInto: timeouts.sort
    }  # fmt: skip
    faults: list[Layer] = []
    if description.faults is not None:
        faults = [Faults(description.faults.plan(), len(description.viewpoints))]
    bins = [Bins(description.bin_numbers)] if numbered else []
    return [*faults, Deadlines(seconds, timeouts.scan), *bins]
