"""Configuration of the simulated cell. All fields are plain data: `dataclasses.asdict` returns JSON."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from beltsort.errors import CellError
from beltsort.geometry import BeltLayout, Pose, SphereViewpoint
from beltsort.sim.bulbs import CLASSES
from beltsort.sim.rotations import rotation
from beltsort.sim.sensor import Camera, SensorNoise
from beltsort.util.naming import suggests_keywords

TRAINING_OBJECTS = 40
"""Objects that a classifier is trained on, unless said otherwise, per class, viewpoint and position."""

TABLE_OBJECTS = 100
"""Independent objects, unless said otherwise, per row of the observation tables."""


@suggests_keywords
@dataclass(frozen=True)
class Cup:
    """A conical cup; the height and radius of its rim are the belt layout's.

    Attributes
    ----------
    floor_radius
        Inner radius at its floor, metres.
    floor_height
        Height of its inner floor above the belt, metres.
    wall
        Thickness of its wall, metres.
    """

    floor_radius: float = 0.022
    floor_height: float = 0.003
    wall: float = 0.003


@suggests_keywords
@dataclass(frozen=True)
class PoseMix:
    """Distribution of the poses of objects in their cups, drawn once per object.

    Attributes
    ----------
    upright, leaning, lying
        Relative frequencies.
    upright_tilt, leaning_tilt, lying_tilt
        Range of the angle between the object's axis and the vertical, degrees; beyond 90 the cap points up.
    """

    upright: float = 0.3
    leaning: float = 0.4
    lying: float = 0.3
    upright_tilt: tuple[float, float] = (0.0, 10.0)
    leaning_tilt: tuple[float, float] = (10.0, 45.0)
    lying_tilt: tuple[float, float] = (60.0, 110.0)

    def __post_init__(self) -> None:
        """Check that the frequencies define a distribution."""
        frequencies = (self.upright, self.leaning, self.lying)
        if min(frequencies) < 0.0 or not 0.0 < sum(frequencies) < np.inf:
            raise CellError(
                f"upright, leaning and lying are {frequencies}, expected finite numbers, none negative, one "
                "above 0; give relative frequencies such as (0.3, 0.4, 0.3)"
            )


@suggests_keywords
@dataclass(frozen=True)
class ArmErrors:
    """Repeatability of the arm: standard deviations, per axis, of the camera's true pose about the reported.

    The error is drawn independently for each scan. The defaults are those of a low-cost compliant arm; an
    industrial arm has 0.0001 m and 0.01 degrees.

    Attributes
    ----------
    position
        Metres.
    angle
        Degrees.
    """

    position: float = 0.003
    angle: float = 0.4

    def true_pose(self, reported: Pose, rng: np.random.Generator) -> Pose:
        """Draw the camera's true pose when the arm reports `world_from_camera`, shape (4, 4)."""
        error = np.eye(4)
        error[:3, :3] = rotation(rng.normal(0.0, np.radians(self.angle), 3))
        error[:3, 3] = rng.normal(0.0, self.position, 3)
        return reported @ error


@suggests_keywords
@dataclass(frozen=True)
class CellConfig:
    """Configuration of the simulated cell.

    Attributes
    ----------
    classes
        Names of the object classes.
    meshes
        Mesh files by class, instead of the built-in shape; required for classes without a built-in shape. Of
        several files of a class, one is drawn for each object.
    size_spread
        Standard deviation of the logarithm of an object's length and, independently, of its diameter.
    belt_width
        Metres.
    upstream
        Number of cups upstream of the last position that are simulated, since they are visible too.
    reject_bin
        Bin index under which `sort` accepts undecided objects, or None.
    move_seconds, scan_seconds, sort_seconds, advance_seconds
        Duration of each action on the simulated clock; that of a move may be given from each of the K
        viewpoints to each, ``move_seconds[start][end]``.
    """

    classes: tuple[str, ...] = CLASSES
    viewpoints: tuple[SphereViewpoint, ...] = (
        SphereViewpoint("p1", azimuth=90.0, elevation=25.0),
        SphereViewpoint("p2", azimuth=180.0, elevation=45.0),
        SphereViewpoint("p3", azimuth=-120.0, elevation=70.0),
    )
    layout: BeltLayout = field(default_factory=BeltLayout)
    cup: Cup = field(default_factory=Cup)
    poses: PoseMix = field(default_factory=PoseMix)
    camera: Camera = field(default_factory=Camera)
    noise: SensorNoise = field(default_factory=SensorNoise)
    arm: ArmErrors = field(default_factory=ArmErrors)
    meshes: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)
    size_spread: float = 0.05
    belt_width: float = 0.2
    upstream: int = 1
    reject_bin: int | None = None
    move_seconds: float | tuple[tuple[float, ...], ...] = 2.0
    scan_seconds: float = 0.1
    sort_seconds: float = 3.0
    advance_seconds: float = 1.5

    def __post_init__(self) -> None:
        """Check that names are unique, the reject bin is not a class's, and numbers are in range."""
        self._check_numbers()
        names = [v.name for v in self.viewpoints]
        for what, given in (("class", list(self.classes)), ("viewpoint", names)):
            if not given or len(set(given)) < len(given):
                raise CellError(f"{what} names are {given}, expected at least one, none twice; rename them")
        unknown = set(self.meshes) - set(self.classes)
        if unknown:
            raise CellError(
                f"meshes names {sorted(unknown)}, expected classes out of {list(self.classes)}; correct the "
                "names"
            )
        if without := [name for name in self.meshes if not self.mesh_files(name)]:
            raise CellError(f"meshes gives no file for {without}, expected one or more: name them")
        if self.reject_bin is not None and self.reject_bin < len(self.classes):
            raise CellError(
                f"reject_bin is {self.reject_bin}, expected None or at least {len(self.classes)}, the number "
                "of classes; choose another"
            )

    def seconds_of_move(self, start: int, end: int) -> float:
        """Return the duration of a move from a viewpoint to another one."""
        moves = self.move_seconds
        return moves if isinstance(moves, float | int) else moves[start][end]

    def mesh_files(self, name: str) -> tuple[str, ...]:
        """Return the mesh files of a class, none for a built-in shape."""
        given = self.meshes.get(name, ())
        return (given,) if isinstance(given, str) else tuple(given)

    def _check_numbers(self) -> None:
        moves, viewpoints = self.move_seconds, len(self.viewpoints)
        if not isinstance(moves, float | int):
            lengths = [len(row) for row in moves]
            if lengths != [viewpoints] * viewpoints:
                raise CellError(
                    f"move_seconds has rows of {lengths} numbers, expected {viewpoints} rows of "
                    f"{viewpoints}: give one for each viewpoint, or one number for all moves"
                )
        for name, value, least in (
            ("size_spread", self.size_spread, 0),
            ("upstream", self.upstream, 0),
            ("layout.positions", self.layout.positions, 1),
        ):
            if not least <= value < np.inf:
                raise CellError(
                    f"{name} is {value}, expected a finite number, at least {least}; start from the default"
                )
