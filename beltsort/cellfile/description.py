"""The cell file: what a robot cell consists of, as TOML (docs/cell.md)."""

import tomllib
from dataclasses import asdict
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, NonNegativeInt, PositiveInt, PrivateAttr

from beltsort.cell.placement import Placement
from beltsort.cellfile.consistency import contradictions
from beltsort.cellfile.problems import CellFileError
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
from beltsort.cellfile.validation import OWN_CHECKS, Section, validated
from beltsort.errors import ViewpointError
from beltsort.geometry import BeltLayout
from beltsort.perception.config import PerceptionConfig
from beltsort.sorting.rules import Drift, Rules

VERSION = 1


class CellDescription(Section):
    """A robot cell, as its file describes it.

    The world of a cell is its belt's frame (`beltsort.geometry`); drivers tell and are told poses in the
    robot's world, and `placement` leads from one to the other.

    Examples
    --------
    >>> cell = CellDescription.load("examples/simulated.toml")
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
    """The sorter's number of the bin of each class; 0, 1, 2, ... in the order of the classes if missing."""
    reject_bin: NonNegativeInt | None = None
    """The sorter's number of the bin for undecided objects; none if missing."""
    objects: PositiveInt = 10
    """How many belt places a run works through."""
    belt_ends: bool = False
    """Whether nothing follows them: planners then take their time with the last ones."""
    model: str | None = None
    """Model file (JSON), tables included."""
    classifier: str | None = None
    """File of the trained classifier (.npz)."""
    prepare: Prepare | None = None
    """In place of model and classifier, for a simulated cell: how much it is trained and counted on."""
    viewpoints: Annotated[tuple[Viewpoint, ...], Field(min_length=1)]
    """Where the camera can stand, in the order of the model's viewpoints; the first is where a run starts."""
    arm: ArmSection
    """Carries the camera."""
    camera: CameraSection
    """Takes scans."""
    belt: BeltSection
    """Carries the objects."""
    sorter: DeviceSection
    """Puts objects into bins."""
    backends: dict[str, Options] = Field(default_factory=dict)
    """Options of a back-end for every device that it drives, by the back-end's name."""
    perception: Annotated[PerceptionConfig, OWN_CHECKS] | None = None
    """Settings of perception; the classifier's own if missing."""
    planner: Planner = Planner()
    """The planner's budget and scenarios."""
    rules: Rules = Rules()
    """Limits of the loop."""
    drift: Annotated[Drift, OWN_CHECKS] | None = None
    """The watch over the observation tables; none if missing."""
    timeouts: Timeouts = Timeouts()
    """How long each kind of command may take."""
    check: CheckLimits = CheckLimits()
    """What `beltsort check` tolerates."""
    faults: FaultSection | None = None
    """Faults that are injected on purpose."""
    _folder: Path = PrivateAttr(default=Path())

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """Read a cell file.

        Raises
        ------
        CellFileError
            If it cannot be read, or with everything that is wrong in it.
        """
        description = validated(cls, _read(Path(path)))
        if problems := list(contradictions(description)):
            raise CellFileError(problems)
        description._folder = Path(path).parent
        return description

    @property
    def bin_numbers(self) -> tuple[int, ...]:
        """The sorter's bin of each label, the reject bin's, if there is one, behind the classes'."""
        numbers = [self.bins.get(name, label) for label, name in enumerate(self.classes)]
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
        """Where the belt lies in the robot's world, and the camera on its flange."""
        belt, hand_eye = self.belt.world_from_belt, self.camera.flange_from_camera
        return Placement(None if belt is None else belt.pose(), None if hand_eye is None else hand_eye.pose())

    def device(self, role: str) -> DeviceSection:
        """Return the table of `arm`, `camera`, `belt` or `sorter`."""
        section: DeviceSection = getattr(self, role)
        return section

    def options_of(self, role: str) -> Options:
        """Return the options of a device's back-end: those for all its devices, and the device's own."""
        section = self.device(role)
        return self.backends.get(section.backend, {}) | section.options

    def path(self, name: str) -> Path:
        """Return a path that the file names; a relative one counts from the file's folder."""
        return self._folder / name


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
    """Return the viewpoints of a file that `beltsort viewpoints` wrote, as a cell file gives them."""
    from beltsort.viewpoints import ViewpointMap

    try:
        return [asdict(viewpoint) for viewpoint in ViewpointMap.load(path).viewpoints]
    except ViewpointError as reason:
        raise CellFileError.of("viewpoints", f"names {path}: {reason}") from reason
