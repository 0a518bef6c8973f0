"""The cell file: the description of a robot cell in TOML (docs/cell.md)."""

import tomllib
from collections.abc import Iterator
from dataclasses import asdict, fields
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from beltsort.cell.placement import Placement
from beltsort.cellfile.moving import USED_RULES, Moving
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.roles import MOVING_ROLES, ROLES, TABLES
from beltsort.cellfile.sections import (
    ArmSection,
    BeltSection,
    CameraSection,
    CheckLimits,
    DeviceSection,
    FaultSection,
    Options,
    Planner,
    Prepare,
    Timeouts,
    Viewpoint,
)
from beltsort.cellfile.validation import Section, validated
from beltsort.errors import ViewpointError
from beltsort.geometry import BeltLayout
from beltsort.perception.config import PerceptionConfig
from beltsort.ros2.options import NodeOptions
from beltsort.sorting.rules import Drift, Rules
from beltsort.util.extras import extra
from beltsort.util.naming import nearest_of
from beltsort.util.problems import Problem
from beltsort.util.validation import OWN_CHECKS

with extra("cell"):
    from pydantic import BeforeValidator, Field, NonNegativeInt, PositiveInt, PrivateAttr

VERSION = 1
NO_SORTER = Problem("sorter", "is missing; add it, or [moving] if the belt never stops")
UNLIMITED = "unlimited"
"""The number of objects of a run that goes on until it is told to stop."""


class CellDescription(Section):
    """A robot cell as described by its file.

    Poses of viewpoints are in the belt frame (`beltsort.geometry`), poses of devices in the robot's world
    frame; `placement` is the transform between them.

    Examples
    --------
    >>> from importlib.resources import as_file, files
    >>> with as_file(files("beltsort.cellfile") / "examples" / "simulated.toml") as path:
    ...     cell = CellDescription.load(path)
    >>> cell.classes
    ('elongated', 'livarno', 'mushroom', 'standard')
    >>> cell.layout.spacing
    0.18
    """

    version: Literal[1]
    """Version of the file's format: 1."""
    classes: Annotated[tuple[str, ...], Field(min_length=1)]
    """Names of the object classes, in the order of the model's."""
    bins: dict[str, NonNegativeInt] = Field(default_factory=dict)
    """The sorter's number of each of the model's bins; 0, 1, 2, ... for those of the classes if missing."""
    reject_bin: NonNegativeInt | None = None
    """The sorter's number of the bin for undecided objects; none if missing."""
    objects: Annotated[PositiveInt | None, BeforeValidator(lambda n: None if n == UNLIMITED else n)] = 10
    """Number of objects in a run, empty cups included, or "unlimited": until it is told to stop (None)."""
    keep_runs: PositiveInt | None = None
    """Number of earlier runs of this cell that are kept when a new one starts; all if missing."""
    belt_ends: bool = False
    """Whether no objects follow; the planner then spends more looks on the last ones."""
    model: str | None = None
    """Model file (JSON), tables included."""
    classifier: str | None = None
    """File of the trained classifier (.npz), `module:object`, or the name of an installed one."""
    prepare: Prepare | None = None
    """Instead of model and classifier, for a simulated cell: numbers of objects for training and tables."""
    viewpoints: Annotated[tuple[Viewpoint, ...], Field(min_length=1)]
    """The camera's viewpoints, in the order of the model's; a run starts at the first."""
    arm: ArmSection
    """The arm that carries the camera."""
    camera: CameraSection
    """The depth camera."""
    belt: BeltSection
    """The belt."""
    sorter: DeviceSection | None = None
    """The sorter, which puts objects into bins; none with `moving`."""
    moving: Moving | None = None
    """A belt that never stops; it stops if missing."""
    backends: dict[str, Options] = Field(default_factory=dict)
    """Options by back-end, for all devices that it drives."""
    perception: Annotated[PerceptionConfig, OWN_CHECKS] | None = None
    """Settings of perception; the classifier's own if missing."""
    planner: Planner = Planner()
    """The planner's budget and scenarios."""
    rules: Rules = Rules()
    """Limits of the loop."""
    drift: Annotated[Drift, OWN_CHECKS] | None = None
    """Drift detection; off if missing."""
    timeouts: Timeouts = Timeouts()
    """Timeout of each kind of command."""
    check: CheckLimits = CheckLimits()
    """Limits of `beltsort check`."""
    faults: FaultSection | None = None
    """Faults to inject."""
    ros2: Annotated[NodeOptions, OWN_CHECKS] | None = None
    """The node by which a run is published on ROS 2; none if missing."""
    _file: Path = PrivateAttr(default=Path())

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """Read a cell file.

        Raises
        ------
        CellFileError
            If it cannot be read or is invalid, with all its problems.
        """
        given = _read(Path(path))
        without = [] if {"sorter", "moving"} & given.keys() else [NO_SORTER]
        try:
            description = validated(cls, given)
        except CellFileError as error:
            raise CellFileError([*error.problems, *without]) from None
        if problems := [*without, *contradictions(description)]:
            raise CellFileError(problems)
        description._file = Path(path)
        return description

    @property
    def file(self) -> Path:
        """The cell file."""
        return self._file

    @property
    def bin_names(self) -> tuple[str, ...]:
        """Names of the bins: the classes, in their order, or others in the order of `bins`."""
        return self.classes if set(self.bins) in (set(), set(self.classes)) else tuple(self.bins)

    @property
    def bin_numbers(self) -> tuple[int, ...]:
        """The sorter's number of each bin, followed by that of the reject bin if there is one."""
        numbers = [self.bins.get(name, index) for index, name in enumerate(self.bin_names)]
        return tuple(numbers if self.reject_bin is None else [*numbers, self.reject_bin])

    @property
    def viewpoint_names(self) -> tuple[str, ...]:
        """Names of the viewpoints."""
        return tuple(viewpoint.name for viewpoint in self.viewpoints)

    @property
    def layout(self) -> BeltLayout:
        """The belt's geometry."""
        belt = self.belt
        return BeltLayout(
            belt.positions, belt.spacing, belt.rim_height, belt.rim_radius, belt.crop_height, belt.crop_radius
        )

    @property
    def placement(self) -> Placement:
        """The belt's pose in the robot's world frame, and the camera's on the flange."""
        belt, hand_eye = self.belt.world_from_belt, self.camera.flange_from_camera
        return Placement(None if belt is None else belt.pose(), None if hand_eye is None else hand_eye.pose())

    @property
    def roles(self) -> tuple[str, ...]:
        """The roles of the cell's devices."""
        return ROLES if self.moving is None else MOVING_ROLES

    def device(self, role: str) -> DeviceSection:
        """Return the table of one of the cell's roles."""
        section: DeviceSection = getattr(self, TABLES[role])
        return section

    def options_of(self, role: str) -> Options:
        """Return the options of a device: those of its back-end, overridden by the device's own."""
        section = self.device(role)
        return self.backends.get(section.backend, {}) | section.options

    def path(self, name: str) -> Path:
        """Return a path in the file, resolved relative to the file's folder."""
        return self._file.parent / name


def _read(path: Path) -> dict[str, Any]:
    try:
        given = tomllib.loads(path.read_text())
    except (OSError, ValueError) as reason:
        raise CellFileError.of(
            "", f"cannot read {path}: {reason}; expected a cell file (TOML): see docs/cell.md"
        ) from reason
    if given.get("version") != VERSION:
        found = given.get("version", "missing")
        raise CellFileError.of("version", f"is {found} in {path}, expected {VERSION}: write version = 1")
    if isinstance(file := given.get("viewpoints"), str):
        given["viewpoints"] = _viewpoints_in(path.parent / file)
    return given


def _viewpoints_in(path: Path) -> list[dict[str, Any]]:
    """Return the viewpoints of a file that `beltsort viewpoints` wrote, in the cell file's format."""
    from beltsort.viewpoints import ViewpointMap

    try:
        return [asdict(viewpoint) for viewpoint in ViewpointMap.load(path).viewpoints]
    except ViewpointError as reason:
        raise CellFileError.of("viewpoints", f"names {path}: {reason}") from reason


def contradictions(cell: CellDescription) -> Iterator[Problem]:
    """Yield the inconsistencies between keys of a file whose keys are valid individually."""
    for key, names in (("classes", cell.classes), ("viewpoints", cell.viewpoint_names)):
        if len(set(names)) < len(names):
            yield Problem(key, f"are named {list(names)}, expected no name twice: rename them")
    if cell.objects is None and cell.belt_ends:
        yield Problem("belt_ends", 'is true, but objects is "unlimited"; give their number, or leave one out')
    yield from _bins(cell)
    yield from _model_files(cell)
    yield from _joints(cell)
    if cell.moving is not None:
        yield from _beside_moving(cell)
        yield from _shapes(cell, cell.moving)
    devices = (cell.arm, cell.camera, cell.belt, cell.sorter)
    known = list(dict.fromkeys(device.backend for device in devices if device is not None))
    for name in cell.backends:
        if name not in known:
            yield Problem(f"backends.{name}", f"has options, but drives no device; {nearest_of(name, known)}")


def _bins(cell: CellDescription) -> Iterator[Problem]:
    """Yield problems of the bins; those of a model file are compared when it is read."""
    if cell.prepare is not None and cell.bin_names != cell.classes:
        given, expected = sorted(cell.bins), sorted(cell.classes)
        yield Problem("bins", f"are given for {given}, expected {expected}: name one for each class")
        return
    for name, number in zip(cell.bin_names, cell.bin_numbers, strict=False):
        if number == cell.reject_bin:
            yield Problem(
                "reject_bin",
                f'is {number}, the number of bin "{name}"; expected one into which no class is sorted: '
                "choose another",
            )


def _model_files(cell: CellDescription) -> Iterator[Problem]:
    for key in ("model", "classifier"):
        file = getattr(cell, key)
        if cell.prepare is None and file is None:
            yield Problem(key, "is missing; name the file, or add [prepare] if the cell is simulated")
        if cell.prepare is not None and file is not None:
            yield Problem(key, f"is {file!r}, but there is [prepare], which makes one: leave one of them out")


def _joints(cell: CellDescription) -> Iterator[Problem]:
    limits = cell.arm.joint_limits
    for number, viewpoint in enumerate(cell.viewpoints):
        joints, where = viewpoint.joints, f"viewpoints[{number}].joints"
        if limits is None or joints is None:
            continue
        if len(joints) != len(limits):
            yield Problem(where, f"has {len(joints)} angles, expected {len(limits)} as in arm.joint_limits")
            continue
        for axis, (angle, (least, most)) in enumerate(zip(joints, limits, strict=True)):
            if not least <= angle <= most:
                what = f"is {angle:g}, expected {least:g} to {most:g} (arm.joint_limits): teach it again"
                yield Problem(f"{where}[{axis}]", what)


def _beside_moving(cell: CellDescription) -> Iterator[Problem]:
    """Yield what a cell file with [moving] must not have."""
    if cell.sorter is not None:
        yield Problem("sorter", "is given, but with [moving] the belt diverts objects itself: leave it out")
    for key in ("reject_bin", "drift", "faults", "ros2"):
        if getattr(cell, key) is not None:
            yield Problem(key, "is given, but cannot be used with [moving]: leave it out")
    if cell.belt_ends:
        yield Problem(
            "belt_ends", "is true, but with [moving] a belt ends with its last object: leave it out"
        )
    rules = Rules()
    for field in fields(Rules):
        value = getattr(cell.rules, field.name)
        if field.name not in USED_RULES and value != getattr(rules, field.name):
            used = ", ".join(USED_RULES)
            yield Problem(
                f"rules.{field.name}", f"is {value}, but with [moving] only {used} are used: leave it out"
            )


def _shapes(cell: CellDescription, moving: Moving) -> Iterator[Problem]:
    """Yield what in the table does not fit positions, viewpoints and classes."""
    positions, viewpoints = cell.belt.positions, len(cell.viewpoints)
    if moving.reach > positions:
        yield Problem(
            "moving.reach", f"is {moving.reach}, expected at most {positions}, the belt's positions: lower it"
        )
    if not isinstance(moving.move_ticks, int):
        lengths = [len(row) for row in moving.move_ticks]
        if lengths != [viewpoints] * viewpoints:
            yield Problem(
                "moving.move_ticks",
                f"has rows of {lengths} numbers, expected {viewpoints} rows of {viewpoints}: one for each "
                "viewpoint, or give one number for all moves",
            )
    for name in moving.missed:
        if name not in cell.classes:
            yield Problem(f"moving.missed.{name}", f"is no class; {nearest_of(name, list(cell.classes))}")
    unpriced = [name for name in cell.classes if name not in moving.missed]
    if moving.missed and unpriced:
        yield Problem(
            "moving.missed", f"has no price of {unpriced}: give one for each class, or leave it out"
        )
