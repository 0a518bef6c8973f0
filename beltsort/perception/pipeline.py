"""From a scan to labels."""

from dataclasses import dataclass, fields

from beltsort import SortingModel
from beltsort.errors import DatabaseError
from beltsort.geometry import BeltLayout, Points
from beltsort.perception.classifier import Classifier, Match
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.finding import Finding
from beltsort.perception.kernel_ridge import KernelRidge
from beltsort.perception.label_rule import LabelRule, rule_of
from beltsort.perception.named_classifier import as_classifier
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.pose_fault import PoseFault
from beltsort.perception.probabilities import ProbabilityClassifier
from beltsort.perception.segment import DepthScan, Segmented, segment
from beltsort.util.representation import short_repr


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
        Index of the label, that of a class unless a `LabelRule` is used. None: there is nothing to label, or
        the classifier rejects it.
    match
        What the classifier returned; None where nothing was classified.
    finding
        What was found, or why nothing was.
    pose_fault
        What is likely wrong with the pose of the whole scan; None if the belt is where it says.
    """

    position: int
    points: Points | None
    label: int | None = None
    match: Match | None = None
    finding: Finding = Finding.OBJECT
    pose_fault: PoseFault | None = None

    __repr__ = short_repr

    @property
    def distance(self) -> float | None:
        """As in `Match`; None where nothing was classified, or from a classifier without distances."""
        return None if self.match is None else self.match.distance

    @property
    def runner_up(self) -> float | None:
        """As in `Match`; None where nothing was classified, or from a classifier without distances."""
        return None if self.match is None else self.match.runner_up

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
        A trained database, any other `Classifier`, or a `ProbabilityClassifier`.
    config
        Must equal the one that a database was trained with, which is the default; `PerceptionConfig()` with
        another classifier.
    rule
        From what the classifier returns to a label; default: the label is the class.

    Raises
    ------
    DatabaseError
        If `config` is another one than the database's, the rule is for other classes, or `classifier` is no
        classifier.
    """

    def __init__(
        self,
        layout: BeltLayout,
        classifier: Classifier | ProbabilityClassifier,
        config: PerceptionConfig | None = None,
        rule: LabelRule | None = None,
    ) -> None:
        classifier = as_classifier(classifier)
        trained = classifier.config if isinstance(classifier, NearestNeighbour | KernelRidge) else config
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
        rule = rule or LabelRule(tuple(classifier.classes))
        if rule.classes != tuple(classifier.classes):
            raise DatabaseError(
                f"the rule labels the classes {list(rule.classes)}, expected the classifier's "
                f"{list(classifier.classes)}, in this order: fit the rule with this classifier"
            )
        self.layout = layout
        self.classifier = classifier
        self.config = config
        self.rule = rule

    def __repr__(self) -> str:
        """Return the classifier, the number of positions and the labels."""
        labels = ", ".join(self.labels)
        return f"Perception({self.classifier!r}, positions {self.layout.positions}, labels {labels})"

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the labels, into which `Perceived.label` is an index."""
        return self.rule.labels

    def __call__(self, scan: DepthScan, layout: BeltLayout | None = None) -> list[Perceived]:
        """Return what is perceived at each of the H positions, the belt end first.

        Parameters
        ----------
        scan
            As in `segment`.
        layout
            Where the objects stand in this scan; default: the layout of this perception.

        Raises
        ------
        CloudError
            If the scan is no point cloud or holds no finite point.

        Warns
        -----
        UnitWarning, PoseWarning
            As `segment`.
        """
        layout = self.layout if layout is None else layout
        segmented = segment(scan, layout, self.config)
        return [self._perceive(segmented, position) for position in range(layout.positions)]

    def _perceive(self, segmented: Segmented, position: int) -> Perceived:
        points, finding = segmented.candidates[position], segmented.findings[position]
        match = None
        if points is not None and finding is Finding.OBJECT:
            match = self.classifier.classify(points, segmented.camera)
        label = self.rule.label(match, finding)
        return Perceived(position, points, label, match, finding, segmented.pose_fault)


def perception_for(
    model: SortingModel,
    layout: BeltLayout,
    classifier: Classifier | ProbabilityClassifier,
    config: PerceptionConfig | None = None,
) -> Perception:
    """Return the perception that gives the labels of a model.

    Parameters
    ----------
    model
        The model. If it keeps a `label_rule`, this rule makes the labels; otherwise they are the classifier's
        classes.
    layout, classifier, config
        As in `Perception`.

    Raises
    ------
    ArgumentError
        If the rule is not valid, or makes other labels than the model's.
    DatabaseError
        As in `Perception`.
    """
    return Perception(layout, classifier, config, None if model.label_rule is None else rule_of(model))
