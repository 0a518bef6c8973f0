"""The tables of a cell file.

Lengths are in metres, times in seconds, joint angles in radians, all other angles in degrees.
"""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np

from beltsort import Despot, SortingModel
from beltsort._core import DEFAULT_SCENARIOS
from beltsort.cell.commands import TIMEOUT
from beltsort.cell.frames import from_matrix, from_quaternion
from beltsort.cellfile.validation import Section
from beltsort.geometry import Pose, look_at, on_sphere
from beltsort.planning.named_policy import DEFAULT_TRIALS, named_policy
from beltsort.planning.policy import Policy
from beltsort.sim.config import TABLE_OBJECTS, TRAINING_OBJECTS
from beltsort.testing.fault_kinds import Fault
from beltsort.testing.faults import FaultPlan
from beltsort.util.extras import extra

with extra("cell"):
    from pydantic import Field, FiniteFloat, NonNegativeInt, PositiveFloat, PositiveInt, model_validator

Vector = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Quaternion = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
Matrix = tuple[Quaternion, Quaternion, Quaternion, Quaternion]

Options = dict[str, object]
Seconds = Annotated[PositiveFloat, Field(le=3600.0)]
Probability = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]


class Transform(Section):
    """A rigid transform, given by `matrix` or by `position` and `quaternion`."""

    matrix: Matrix | None = None
    """Four rows of four numbers."""
    position: Vector | None = None
    """x, y, z."""
    quaternion: Quaternion | None = None
    """x, y, z, w, of length 1."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        _one_of(self, [("matrix",), ("position", "quaternion")])
        self.pose()
        return self

    def pose(self) -> Pose:
        """Return the transform as a matrix, shape (4, 4)."""
        if self.position is not None and self.quaternion is not None:
            return from_quaternion(self.position, self.quaternion)
        return from_matrix(self.matrix or ())


class Viewpoint(Section):
    """A viewpoint, given by taught joint angles, by the camera's pose in the belt frame, or both.

    The pose is given in one of four ways: `azimuth` and `elevation` relative to the belt end, `position` and
    `look_at`, `position` and `quaternion`, or `matrix`. The camera frame has x right, y down, z forward.
    """

    name: str
    """Name of the viewpoint."""
    joints: tuple[FiniteFloat, ...] | None = None
    """Taught joint angles, radians, from the base to the flange."""
    azimuth: FiniteFloat | None = None
    """Degrees; 0 is upstream, 180 beyond the belt end."""
    elevation: FiniteFloat | None = None
    """Degrees above the belt; 90 is straight above."""
    radius: PositiveFloat = 0.7
    """Distance from the belt end, metres."""
    position: Vector | None = None
    """x, y, z of the camera, metres."""
    look_at: Vector | None = None
    """x, y, z of the point in the centre of the image, metres."""
    quaternion: Quaternion | None = None
    """x, y, z, w of the camera's rotation, of length 1."""
    matrix: Matrix | None = None
    """The camera's pose, four rows of four numbers."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        ways: list[tuple[str, ...]] = [
            ("azimuth", "elevation"), ("position", "look_at"), ("position", "quaternion"), ("matrix",),
        ]  # fmt: skip
        _one_of(self, ways if self.joints is None else [(), *ways], "joints, or ")
        if self.position is not None and self.position == self.look_at:
            raise ValueError(
                f"position and look_at are both {self.position}, expected different points: correct one of "
                "them"
            )
        self.pose()
        return self

    def pose(self) -> Pose | None:
        """Return `world_from_camera`, shape (4, 4), or None if only joint angles are given."""
        belt_end = np.zeros(3)
        if self.azimuth is not None and self.elevation is not None:
            return look_at(on_sphere(self.azimuth, self.elevation, self.radius, belt_end), belt_end)
        if self.position is not None and self.look_at is not None:
            return look_at(np.array(self.position), np.array(self.look_at))
        if self.position is not None and self.quaternion is not None:
            return from_quaternion(self.position, self.quaternion)
        return None if self.matrix is None else from_matrix(self.matrix)


class DeviceSection(Section):
    """A device and its back-end."""

    backend: str
    """Name of a back-end."""
    options: Options = Field(default_factory=dict)
    """Options of this device; they override those of [backends.NAME]."""


class ArmSection(DeviceSection):
    """The arm."""

    joint_limits: tuple[tuple[FiniteFloat, FiniteFloat], ...] | None = None
    """Minimum and maximum angle of each joint, radians."""


class CameraSection(DeviceSection):
    """The camera."""

    flange_from_camera: Transform | None = None
    """The hand-eye transform: the camera's pose in the frame of the arm's flange."""


class BeltSection(DeviceSection):
    """The belt; lengths as in `beltsort.geometry.BeltLayout`."""

    world_from_belt: Transform | None = None
    """Pose of the belt frame in the robot's world frame; the identity if missing."""
    positions: PositiveInt = 2
    """Number of belt positions seen at once."""
    spacing: PositiveFloat = 0.18
    """Distance between neighbouring positions, metres."""
    rim_height: Annotated[FiniteFloat, Field(ge=0.0)] = 0.05
    """Height of a cup's rim above the belt, metres."""
    rim_radius: PositiveFloat = 0.04
    """Radius of a cup's rim, metres."""
    crop_height: PositiveFloat = 0.25
    """Upper end of the cylinder to which an object is cropped, metres above the belt."""
    crop_radius: PositiveFloat = 0.085
    """Radius of that cylinder, metres."""

    @model_validator(mode="after")
    def _room_above_the_rim(self) -> Self:
        if self.crop_height <= self.rim_height:
            raise ValueError(
                f"crop_height is {self.crop_height} and rim_height {self.rim_height}, expected room for an "
                "object between them: measure both from the belt's surface"
            )
        return self


class Timeouts(Section):
    """Timeout of each kind of command."""

    move: Seconds = TIMEOUT
    """Timeout of a move of the arm, seconds."""
    scan: Seconds = TIMEOUT
    """Timeout of a scan, seconds."""
    sort: Seconds = TIMEOUT
    """Timeout of a sort, seconds."""
    advance: Seconds = TIMEOUT
    """Timeout of an advance of the belt, seconds."""
    divert: Seconds = TIMEOUT
    """Timeout of the acknowledgement of a diversion, and of a query to a belt that never stops, seconds."""


class Planner(Section):
    """The policy that chooses the actions.

    The other keys are for the policy "despot", with [moving] the planner for belts that never stop: its
    budget, `trials` or `seconds` (300 trials if neither, with [moving] 30), and its scenarios.
    """

    policy: str = "despot"
    """Name of a policy, as in `beltsort compare --policies`, or with [moving] in `beltsort throughput`; paths
    start at the file's folder."""
    trials: PositiveInt | None = None
    """Trials per plan, reproducible."""
    seconds: PositiveFloat | None = None
    """Seconds per plan."""
    scenarios: PositiveInt = DEFAULT_SCENARIOS
    """Number of scenarios."""
    seed: NonNegativeInt = 0
    """Seed of the scenarios."""

    @model_validator(mode="after")
    def _one_budget(self) -> Self:
        if self.trials is not None and self.seconds is not None:
            raise ValueError(
                f"trials is {self.trials} and seconds is {self.seconds}, expected one of them: leave one out"
            )
        others = sorted(self.model_fields_set - {"policy"})
        if self.policy != "despot" and others:
            raise ValueError(
                f'policy is "{self.policy}" and {others[0]} is {getattr(self, others[0])}, expected policy = '
                f'"despot" beside it: leave {others[0]} out'
            )
        return self

    def policy_for(self, model: SortingModel, folder: Path) -> Policy:
        """Return the policy.

        Raises
        ------
        ArgumentError
            As `named_policy`.
        """
        if self.policy == "despot":
            return Despot(model, **self.settings())
        return named_policy(self.policy, model, folder)

    def settings(self) -> dict[str, Any]:
        """Return the keyword arguments of `beltsort.Despot`."""
        budget = (
            {"trials": self.trials or DEFAULT_TRIALS} if self.seconds is None else {"seconds": self.seconds}
        )
        return {"scenarios": self.scenarios, "seed": self.seed, **budget}


class Prepare(Section):
    """Training and tables of a simulated cell, computed once and stored in the user's cache folder."""

    training_objects: PositiveInt = TRAINING_OBJECTS
    """Training objects of the classifier per class, viewpoint and position."""
    table_objects: PositiveInt = TABLE_OBJECTS
    """Independent objects per row of the observation tables."""


class CheckLimits(Section):
    """Limits of `beltsort check`."""

    belt_angle: PositiveFloat = 1.0
    """Largest angle between the measured and the expected belt plane, degrees."""
    belt_height: PositiveFloat = 10.0
    """Largest height difference between the two planes at the belt end, millimetres."""
    belt_points: PositiveInt = 1000
    """Smallest number of points on the belt."""
    pose_angle: PositiveFloat = 1.0
    """Largest angle between a known camera pose and the viewpoint's, degrees."""
    pose_distance: PositiveFloat = 10.0
    """Largest distance between a known camera pose and the viewpoint's, millimetres."""
    crop_inside: Annotated[PositiveFloat, Field(le=1.0)] = 1.0
    """Smallest share of a position's crop cylinder that lies inside the image."""
    crop_points: PositiveInt = 100
    """Smallest number of points in a position's crop cylinder."""


class Scheduled(Section):
    """A fault injected into one call."""

    command: Literal["move_to", "advance_to", "sort", "scan"]
    """Name of the call."""
    number: PositiveInt
    """Number of the call with this name, from 1."""
    kind: Fault
    """The kind of fault."""

    @model_validator(mode="after")
    def _applicable(self) -> Self:
        if self.command not in self.kind.affected:
            raise ValueError(
                f"has kind {self.kind.value} for command {self.command}, expected one of "
                f"{', '.join(self.kind.affected)}: a fault of this kind affects no other"
            )
        return self


class FaultSection(Section):
    """Faults to inject, for soak tests."""

    seed: NonNegativeInt = 0
    """Seed of the random faults."""
    rates: dict[Fault, Probability] = Field(default_factory=dict)
    """Probability per call, by kind of fault."""
    schedule: tuple[Scheduled, ...] = ()
    """Faults of particular calls."""

    def plan(self) -> FaultPlan:
        """Return the plan of the faults."""
        return FaultPlan(self.seed, self.rates, {(s.command, s.number): s.kind for s in self.schedule})


def _one_of(section: Section, ways: list[tuple[str, ...]], besides: str = "") -> None:
    """Check that a section has the keys of exactly one of several alternatives."""
    known = sorted({key for way in ways for key in way})
    given = {key for key in known if getattr(section, key) is not None}
    if given not in map(set, ways):
        choices = ", or ".join(" and ".join(way) for way in ways if way)
        raise ValueError(f"has {' and '.join(sorted(given)) or 'no pose'}, expected {besides}{choices}")
