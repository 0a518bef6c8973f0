"""Segmentation of a scan: one cleaned cloud for each belt position."""

import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout, Points, Pose, transform
from beltsort.perception.checks import PoseWarning, as_array, warn_unless_metres
from beltsort.perception.clean import main_clusters, voxel_means, without_outliers
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.finding import Finding
from beltsort.perception.level import levelled
from beltsort.perception.parts import Background, several_objects
from beltsort.perception.pose_fault import PoseFault, pose_fault
from beltsort.perception.visibility import crossings, image_border, share_seen, within_gap
from beltsort.util.representation import short_repr

MOST_POINTS = 4_000_000  # more than a depth camera returns; larger scans are thinned to bound memory
PLAUSIBLE_DISTANCES = (0.02, 20.0)  # metres from the camera
SAMPLES = 1000  # points from which the median distance is computed


class DepthScan(Protocol):
    """A scan as segmentation needs it."""

    @property
    def points(self) -> Points:
        """Points in the camera frame, metres, shape (height, width, 3) or (n, 3); NaN where there is none."""

    @property
    def world_from_camera(self) -> Pose:
        """The camera's reported pose, shape (4, 4)."""


@dataclass(frozen=True)
class Segmented:
    """The result of segmentation.

    Attributes
    ----------
    candidates
        For each position the cleaned points above the rim, shape (n, 3), world frame, metres, or None if
        there are none.
    findings
        For each position what was found, or why nothing was.
    camera
        The camera's position, corrected with the plane of the visible belt, shape (3,), world frame, metres.
    pose_fault
        What is likely wrong with the pose, if the scan does not show the belt where it says; else None.
    """

    candidates: tuple[Points | None, ...]
    findings: tuple[Finding, ...]
    camera: Points
    pose_fault: PoseFault | None = None

    __repr__ = short_repr

    @property
    def objects(self) -> tuple[Points | None, ...]:
        """The candidates that are classified: those with the finding `OBJECT`, None elsewhere."""
        return tuple(
            points if finding is Finding.OBJECT else None
            for points, finding in zip(self.candidates, self.findings, strict=True)
        )


def segment(scan: DepthScan, layout: BeltLayout, config: PerceptionConfig | None = None) -> Segmented:
    """Extract one candidate for each belt position from a scan.

    The points are transformed to the world frame, with the camera's pose corrected by the plane of the
    visible belt. The points in the upright cylinder above each cup are averaged in voxels, outliers are
    removed, and the main clusters kept. The result is deterministic. Of more than `MOST_POINTS` points, an
    evenly spaced subset is used.

    Parameters
    ----------
    scan
        Points in the camera frame, metres, and the camera's pose. Objects that are cut off at the edge of the
        image are detected only in an organised one, shape (height, width, 3).
    layout
        Positions and sizes of the cups.
    config
        Settings; default `PerceptionConfig()`.

    Raises
    ------
    CloudError
        If the points have another shape, or none of them or not all of the pose is finite.

    Warns
    -----
    UnitWarning
        If the distances of points or camera are implausible in metres.
    PoseWarning
        If the scan does not show the belt where its pose says; the candidates are then of wrong places.
    """
    view = View.of(scan, layout, config or PerceptionConfig())
    if view.pose_fault is not None:
        warnings.warn(
            f"the belt is not where the scan's pose says; likely: {view.pose_fault}",
            PoseWarning,
            stacklevel=2,
        )
    positions = range(layout.positions)
    candidates = [view.candidate(position) for position in positions]
    findings = tuple(view.finding(position, candidates[position]) for position in positions)
    found = tuple(None if len(points) == 0 else points for points in candidates)
    return Segmented(found, findings, view.world_from_camera[:3, 3].copy(), view.pose_fault)


@dataclass(frozen=True, eq=False)
class View:
    """A scan with corrected camera pose, and the quantities computed from it for all positions.

    Attributes
    ----------
    border
        The outermost pixels of an organised image, shape (m, 3), camera frame, metres.
    points
        All points, shape (n, 3), camera frame, metres.
    reported
        The camera's pose as it was reported, shape (4, 4).
    world_from_camera
        The camera's pose, corrected with the plane of the visible belt, shape (4, 4).
    layout, config
        As in `segment`.
    """

    border: Points
    points: Points
    reported: Pose
    world_from_camera: Pose
    layout: BeltLayout
    config: PerceptionConfig

    @classmethod
    def of(cls, scan: DepthScan, layout: BeltLayout, config: PerceptionConfig) -> "View":
        """Check a scan and correct its pose. Raises the errors of `segment`."""
        image = _checked(scan)
        points = image.reshape(-1, 3)
        points = points[:: 1 + len(points) // MOST_POINTS]
        reported = np.asarray(scan.world_from_camera, dtype=np.float64)
        return cls(image_border(image), points, reported, levelled(points, reported), layout, config)

    @property
    def base(self) -> float:
        """Height above the belt, metres, below which points belong to cups or belt."""
        return self.layout.rim_height + self.config.rim_clearance

    @cached_property
    def height(self) -> NDArray[np.float64]:
        """Height of each point above the belt, shape (n,), metres; not finite for points that are not."""
        height = _heights(self.points, self.world_from_camera)
        if not np.isfinite(height).any():
            raise CloudError(
                f"none of {len(height)} points in the scan is finite, expected the belt's: check the camera"
            )
        return height

    @cached_property
    def pose_fault(self) -> PoseFault | None:
        """What is likely wrong with the reported pose; None if the belt is where it says."""
        return pose_fault(self.points, self.height, self.reported, self.world_from_camera, self.layout)

    @cached_property
    def above(self) -> Points:
        """The points between the rims and the top of the crop, shape (n, 3), world frame."""
        return self._above_rims(self.points, self.height)

    @cached_property
    def passed(self) -> Points:
        """Points where lines of sight to cups and belt cross the rims' height, shape (m, 2), world frame."""
        return crossings(self.points, self.height, self.world_from_camera, self.base)

    def background(self) -> Background:
        """Return what is seen below the rims; of a list of points nothing, since it may be of many scans."""
        passed = self.passed if len(self.border) > 0 else self.passed[:0]
        return Background(self.world_from_camera[:3, 3], self.base, passed)

    def cropped(self, position: int) -> Points:
        """Return all points above one cup, shape (n, 3), world frame."""
        return self._in_cylinder(self.above, position)

    def candidate(self, position: int) -> Points:
        """Return the cleaned points above one cup, shape (n, 3), world frame; n = 0 if there are too few."""
        voxels = voxel_means(self.cropped(position), self.config.voxel)
        if len(voxels) < self.config.fewest_seen:
            return voxels[:0]
        return main_clusters(without_outliers(voxels, self.config), self.config)

    def finding(self, position: int, candidate: Points) -> Finding:
        """Return the finding for one position, given its candidate, shape (n, 3)."""
        if len(candidate) == 0:
            centre = self.layout.centre(position)[:2]
            seen = share_seen(self.passed, centre, self.layout.rim_radius)
            return Finding.EMPTY if seen >= self.config.opening_seen else Finding.HIDDEN
        if self._cut_off(position, candidate):
            return Finding.CUT
        if several_objects(candidate, self.background, self.config):
            return Finding.SEVERAL
        return Finding.OBJECT if len(candidate) >= self.config.fewest_labelled else Finding.TOO_FEW

    def _cut_off(self, position: int, candidate: Points) -> bool:
        """Whether the candidate reaches the edge of the image."""
        above = self._above_rims(self.border, _heights(self.border, self.world_from_camera))
        border = voxel_means(self._in_cylinder(above, position), self.config.voxel)
        return within_gap(border, candidate, self.config.cluster_gap)

    def _above_rims(self, points: Points, height: NDArray[np.float64]) -> Points:
        """Return the points between rim and top of the crop, world frame."""
        with np.errstate(invalid="ignore"):
            inside = (height > self.base) & (height < self.layout.crop_height)
        return transform(self.world_from_camera, points[np.flatnonzero(inside)])

    def _in_cylinder(self, above: Points, position: int) -> Points:
        """Return the points within the upright cylinder about a position."""
        from_axis = above[:, :2] - self.layout.centre(position)[:2]
        inside: NDArray[np.bool_] = (from_axis**2).sum(axis=1) < self.layout.crop_radius**2
        return above[inside]


def _checked(scan: DepthScan) -> Points:
    """Return the points of a scan, after checking their shape, the pose, and that lengths may be metres."""
    points: Points = as_array("the scan's points", scan.points, CloudError)
    pose = as_array("world_from_camera", scan.world_from_camera, CloudError)
    if points.ndim not in (2, 3) or points.shape[-1] != 3:
        raise CloudError(
            f"the scan's points have shape {points.shape}, expected (height, width, 3) or (n, 3): "
            "give coordinates in metres, not a depth image"
        )
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise CloudError(
            f"world_from_camera is {pose.tolist()}, expected a finite (4, 4) transform: check the arm"
        )
    from_belt = float(np.linalg.norm(pose[:3, 3]))
    warn_unless_metres("the camera's distance from the belt end", from_belt, (0.0, PLAUSIBLE_DISTANCES[1]))
    sample = points.reshape(-1, 3)[:: 1 + points.size // (3 * SAMPLES)]
    distances = np.sqrt((sample[np.isfinite(sample).all(axis=1)] ** 2).sum(axis=1))
    if len(distances) > 0:
        warn_unless_metres("the points' median distance", float(np.median(distances)), PLAUSIBLE_DISTANCES)
    return points


def _heights(points: Points, world_from_camera: Pose) -> NDArray[np.float64]:
    """Return the z coordinates of points in the world frame, shape (n,)."""
    with np.errstate(invalid="ignore"):
        # Not `@`: BLAS would start threads, which slow the rest down when all cores are busy.
        height: NDArray[np.float64] = np.einsum("ij,j->i", points, world_from_camera[2, :3])
    height += world_from_camera[2, 3]
    return height
