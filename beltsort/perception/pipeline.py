"""From a scan to labels."""

from dataclasses import dataclass, fields

from beltsort.errors import DatabaseError
from beltsort.geometry import BeltLayout, Points
from beltsort.perception.classifier import Classifier
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.finding import Finding
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.segment import DepthScan, segment


@dataclass(frozen=True, eq=False)
class Perceived:
    """What one scan shows of one belt position.

    Attributes
    ----------
    position
        Index of the belt position, 0 at the belt end.
    points
        The candidate, shape (n, 3), world frame, metres; None if there is none.
    label
        Class index, or None: there is nothing to label, or the classifier rejects it.
    distance, runner_up
        As in `Match`; None where nothing was classified, or from a classifier without distances.
    finding
        What was found, or why nothing was.
    """

    position: int
    points: Points | None
    label: int | None = None
    distance: float | None = None
    runner_up: float | None = None
    finding: Finding = Finding.OBJECT

    @property
    def empty(self) -> bool:
        """Whether the scan saw that nothing stands here; a candidate without a label is not empty."""
        return self.finding is Finding.EMPTY


class Perception:
    """Labels what stands at each belt position.

    Parameters
    ----------
    layout
        Where the objects stand.
    classifier
        A trained database, or any other `Classifier`.
    config
        Must equal the one that a database was trained with, which is the default; `PerceptionConfig()` with
        another classifier.

    Raises
    ------
    DatabaseError
        If `config` is another one than the database's.
    """

    def __init__(
        self, layout: BeltLayout, classifier: Classifier, config: PerceptionConfig | None = None
    ) -> None:
        trained = classifier.config if isinstance(classifier, NearestNeighbour) else config
        trained = trained or PerceptionConfig()
        config = config or trained
        differing = [
            f"{f.name} {getattr(config, f.name)} (database: {getattr(trained, f.name)})"
            for f in fields(PerceptionConfig)
            if getattr(config, f.name) != getattr(trained, f.name)
        ]
        if differing:
            raise DatabaseError(
                f"the configuration has {', '.join(differing)}, expected the database's own: "
                "pass config=classifier.config or train again"
            )
        self.layout = layout
        self.classifier = classifier
        self.config = config

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the labels, into which `Perceived.label` is an index."""
        return self.classifier.classes

    def __call__(self, scan: DepthScan) -> list[Perceived]:
        """Return what is perceived at each of the H positions, the belt end first.

        Raises
        ------
        CloudError
            If the scan is no point cloud or holds no finite point.
        """
        segmented = segment(scan, self.layout, self.config)
        found = zip(segmented.candidates, segmented.findings, strict=True)
        return [self._perceive(j, *what, segmented.camera) for j, what in enumerate(found)]

    def _perceive(self, position: int, points: Points | None, finding: Finding, camera: Points) -> Perceived:
        if points is None or finding is not Finding.OBJECT:
            return Perceived(position, points, finding=finding)
        match = self.classifier.classify(points, camera)
        return Perceived(position, points, match.label, match.distance, match.runner_up)
