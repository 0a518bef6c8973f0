"""From a scan to labels."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from beltsort.errors import DatabaseError
from beltsort.geometry import BeltLayout, Points
from beltsort.perception.checks import warn_unless_metres
from beltsort.perception.classifier import NearestNeighbour
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.normals import oriented_normals
from beltsort.perception.outcome import Outcome
from beltsort.perception.segment import DepthScan, segment
from beltsort.perception.vfh import Histogram, checked_view, vfh

PLAUSIBLE_EXTENTS = (0.001, 5.0)  # metres


@dataclass(frozen=True, eq=False)
class Perceived:
    """What one scan says about one belt position.

    Attributes
    ----------
    position
        Index of the belt position, 0 at the belt end.
    points
        The candidate, shape (n, 3), world frame, metres; None if there is none.
    label
        Class index, or None: there is nothing to label.
    distance
        Distance of the candidate's descriptor to the nearest one in the database; None without a label.
    runner_up
        Distance to the nearest one of another class, infinite if there is none; None without a label.
    outcome
        What was found, or why nothing was.
    """

    position: int
    points: Points | None
    label: int | None = None
    distance: float | None = None
    runner_up: float | None = None
    outcome: Outcome = Outcome.OBJECT

    @property
    def empty(self) -> bool:
        """Whether the scan saw that nothing stands here; a candidate without a label is not empty."""
        return self.outcome is Outcome.EMPTY


def describe(points: ArrayLike, camera: ArrayLike, config: PerceptionConfig | None = None) -> Histogram:
    """Return the descriptor of a candidate, shape (308,).

    Parameters
    ----------
    points
        Shape (n, 3), metres.
    camera
        The camera's position in the same frame, shape (3,).
    config
        Settings; default `PerceptionConfig()`.

    Raises
    ------
    CloudError
        If the shapes do not fit, a value is no finite number, there are fewer than three points, or
        the camera is their centroid.

    Warns
    -----
    UnitWarning
        If no object that a robot picks is of that extent in metres.
    """
    config = config or PerceptionConfig()
    cloud, _ = checked_view(points, camera)
    warn_unless_metres("the cloud's extent", float(np.ptp(cloud, axis=0).max()), PLAUSIBLE_EXTENTS)
    normals = oriented_normals(points, camera, config.normal_neighbours)
    return vfh(points, normals, viewpoint=camera, size_component=config.size_component)


class Perception:
    """Labels what stands at each belt position.

    Parameters
    ----------
    layout
        Where the objects stand.
    classifier
        The trained database.
    config
        Must equal the one that the database was trained with, which is the default.

    Raises
    ------
    DatabaseError
        If `config` is another one than the database's.
    """

    def __init__(
        self, layout: BeltLayout, classifier: NearestNeighbour, config: PerceptionConfig | None = None
    ) -> None:
        config = config or classifier.config
        differing = [
            f"{f.name} {getattr(config, f.name)} (database: {getattr(classifier.config, f.name)})"
            for f in fields(PerceptionConfig)
            if getattr(config, f.name) != getattr(classifier.config, f.name)
        ]
        if differing:
            raise DatabaseError(
                f"the configuration has {', '.join(differing)}, expected the database's own: "
                "pass config=classifier.config or train again"
            )
        self.layout = layout
        self.classifier = classifier
        self.config = config

    def __call__(self, scan: DepthScan) -> list[Perceived]:
        """Return what is perceived at each of the H positions, the belt end first.

        Raises
        ------
        CloudError
            If the scan is no point cloud or holds no finite point.
        """
        segmented = segment(scan, self.layout, self.config)
        found = zip(segmented.candidates, segmented.outcomes, strict=True)
        return [self._perceive(j, *what, segmented.camera) for j, what in enumerate(found)]

    def _perceive(self, position: int, points: Points | None, outcome: Outcome, camera: Points) -> Perceived:
        if points is None or outcome is not Outcome.OBJECT:
            return Perceived(position, points, outcome=outcome)
        match = self.classifier.match(describe(points, camera, self.config))
        return Perceived(position, points, match.label, match.distance, match.runner_up)
