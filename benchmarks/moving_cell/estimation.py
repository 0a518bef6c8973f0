"""The classifier and the observation tables of a moving belt, from scans of belts that are only looked at."""

import math
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import beltsort
from beltsort import Move, MovingBelief, SortingModel
from beltsort.cell import Scan
from beltsort.geometry import Points
from beltsort.perception import Classifier, Match, NearestNeighbour, PerceptionConfig, describe
from beltsort.perception.vfh import Histogram
from beltsort.sim import MovingCell
from beltsort.sorting.journal import read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.moving.entries import Looked
from beltsort.tables.modes import fit_modes
from beltsort.tables.repeated_looks import LooksAtObject, RepeatedLooks, TableShape
from beltsort.tracking import TrackedPerception, TrackedScan, Tracker
from beltsort.util.defaults import UNIFORM_PRIOR
from benchmarks.moving_cell.cell import CONFIG, Cell, labels_of, moving_model, run_belt

SURVEY_SPEED = 0.06
SURVEY_SEED, TRAINING_SEED = 10_000, 20_000
R_MIN = 20.0
MODES = 3  # at most, of each class


class Survey:
    """Looks from one viewpoint after the other and decides nothing."""

    def __init__(self) -> None:
        self.looks = 0

    def act(self, belief: MovingBelief, viewpoint: int) -> Move:
        self.looks += 1
        return Move(self.looks // 2 % 3)


class Described:
    """A classifier that keeps the descriptors of what it is given, with its class once that is known."""

    def __init__(self) -> None:
        self.classes = CONFIG.classes
        self.config = PerceptionConfig()
        self.given: list[Histogram] = []
        self.descriptors: list[Histogram] = []
        self.labels: list[int] = []

    def classify(self, points: Points, camera: Points) -> Match:
        self.given.append(describe(points, camera, self.config))
        return Match(0, np.eye(len(self.classes))[0])


class Learner:
    """Perception that tells its classifier what the objects were."""

    def __init__(self, world: MovingCell, perceive: TrackedPerception, belt: int) -> None:
        self.world, self.perceive, self.true = world, perceive, labels_of(belt)

    @property
    def labels(self) -> Sequence[str]:
        return self.perceive.labels

    def __call__(self, scan: Scan, tracker: Tracker) -> TrackedScan:
        described = self.perceive.perception.classifier
        assert isinstance(described, Described)
        described.given.clear()
        seen = self.perceive(scan, tracker)
        travel = self.world.travel(seen.update.stamp)
        for look in (look for look in seen.looks if look.perceived.match is not None):
            descriptor = described.given.pop(0)
            cup = round((look.place + travel) / CONFIG.layout.spacing)
            label = self.true[cup] if 0 <= cup < len(self.true) else None
            if label is not None:
                described.descriptors.append(descriptor)
                described.labels.append(label)
        return seen


def train(belts: int) -> NearestNeighbour:
    """Return a classifier trained on scans of moving belts."""
    described, moving = Described(), moving_model(beltsort.models.paper(), SURVEY_SPEED)
    for belt in range(TRAINING_SEED, TRAINING_SEED + belts):
        with tempfile.TemporaryDirectory() as folder:
            cell = Cell(belt, SURVEY_SPEED)
            perceive = Learner(cell.world, cell.perception(described), belt)
            run_belt(cell, perceive, Survey(), moving, Path(folder))
    return NearestNeighbour.train(described.descriptors, described.labels, CONFIG.classes)


def survey(belts: int, classifier: Classifier) -> tuple[SortingModel, SortingModel]:
    """Return models whose tables were estimated on moving belts.

    The first one has one mode per class; the first look at each object at each place from each viewpoint
    counts. The second one has latent modes, which make repeated looks depend on each other.
    """
    start, names = beltsort.models.paper(), [viewpoint.name for viewpoint in CONFIG.viewpoints]
    moving, objects = moving_model(start, SURVEY_SPEED), list[LooksAtObject]()
    for belt in range(SURVEY_SEED, SURVEY_SEED + belts):
        with tempfile.TemporaryDirectory() as folder:
            cell = Cell(belt, SURVEY_SPEED)
            run_belt(cell, cell.perception(classifier), Survey(), moving, Path(folder))
            objects += surveyed(Path(folder) / JOURNAL, belt, start.positions)
    classes = len(CONFIG.classes)
    looks = RepeatedLooks.of(objects, TableShape(start.positions, len(names), classes, classes))
    counts = looks.first_counts() + UNIFORM_PRIOR
    plain = SortingModel(CONFIG.classes, names, counts / counts.sum(axis=-1, keepdims=True), r_min=R_MIN)
    fitted = fit_modes(looks, MODES)
    weights = [list(each) for each in fitted.weights]
    return plain, SortingModel(
        CONFIG.classes, names, fitted.p_obs, modes=weights, labels=CONFIG.classes, r_min=R_MIN
    )


def prepared_for_moving(belts: int, file: Path) -> tuple[NearestNeighbour, SortingModel, SortingModel]:
    """Return classifier and models of moving belts, kept in files beside `file`."""
    database = file.with_suffix(".npz")
    tables = [file.with_suffix(".json"), file.with_name(f"{file.stem}-modes.json")]
    if not database.exists():
        train(belts).save(database)
    if not all(each.exists() for each in tables):
        for model, each in zip(survey(belts, NearestNeighbour.load(database)), tables, strict=True):
            model.save(each)
    plain, modes = (SortingModel.load(each) for each in tables)
    return NearestNeighbour.load(database), plain, modes


def surveyed(journal: Path, belt: int, positions: int) -> Iterator[LooksAtObject]:
    """Yield the looks at each object, in the order of the cups."""
    spacing, true = CONFIG.layout.spacing, labels_of(belt)
    looks: dict[int, list[tuple[int, int, int | None]]] = defaultdict(list)
    for entry in read_journal(journal):
        if not isinstance(entry.content, Looked):
            continue
        for each in entry.content.seen:
            if each.coordinate is None or each.finding == "empty":
                continue
            place = math.floor((each.coordinate - entry.content.travel) / spacing + 0.5)
            cup = round(each.coordinate / spacing)
            if 0 <= place < positions and 0 <= cup < len(true):
                looks[cup].append((place, entry.content.viewpoint, each.label))
    for cup, its in sorted(looks.items()):
        label = true[cup]
        if label is not None:
            yield LooksAtObject(label, tuple(its))
