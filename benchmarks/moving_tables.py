"""`python -m benchmarks.moving_tables -o FOLDER`: tables of a moving belt, for `beltsort throughput`.

Belts of the simulated cell, with irregular places and some empty cups, move under a camera that only looks.
On half of them the classifier is trained, on the others the observation tables are estimated: with one mode
per class, from the first look at each object at each place from each viewpoint, and with latent modes, which
make repeated looks depend on each other. The folder then has the classifier, both models, and a cell file of
each (`one_mode.toml`, `modes.toml`); and for stop-and-go one of the same cell with classifier and tables of
belts that stand (`standing.toml`).
"""

import argparse
import math
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np

from beltsort import Move, MovingBelief, MovingBelt, SortingModel, models
from beltsort.cell import Scan
from beltsort.cellfile.composed_moving import ComposedMovingCell, compose_moving
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.example import example
from beltsort.cellfile.sorted_belt import seeded, simulated_moving
from beltsort.geometry import Points
from beltsort.perception import (
    Classifier,
    Finding,
    Match,
    NearestNeighbour,
    Perception,
    PerceptionConfig,
    describe,
)
from beltsort.perception.vfh import Histogram
from beltsort.sim.prepare import prepare
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.moving.entries import Looked
from beltsort.sorting.moving.looking import PerceiveMoving
from beltsort.sorting.moving.loop import sort_moving
from beltsort.tables.modes import fit_modes
from beltsort.tables.repeated_looks import LooksAtObject, RepeatedLooks, TableShape
from beltsort.tracking import TrackedPerception, TrackedScan, Tracker
from beltsort.util.defaults import UNIFORM_PRIOR
from beltsort.util.processes import in_processes

OBJECTS = 20  # cups of each belt
SURVEY_SEED, TRAINING_SEED = 10_000, 20_000
R_MIN = 20.0
DISCOUNT = 0.99  # per tick
MODES = 3  # at most, of each class
CHANGES = (
    ("seed = 0", "seed = 0\nempty = 0.1\npitch_jitter = 0.008"),
    (
        "ticks_per_place = 12     # 0.18 m in 6 s: 0.03 m/s",
        "ticks_per_place = 12     # 0.18 m in 3 s: 0.06 m/s",
    ),
    ("seconds_per_tick = 0.5", "seconds_per_tick = 0.25"),
    ("[[0, 4, 4], [4, 0, 4], [4, 4, 0]]", "[[0, 8, 8], [8, 0, 8], [8, 8, 0]]"),
)


class Survey:
    """Looks twice from one viewpoint after the other, and decides nothing."""

    def __init__(self) -> None:
        self.looks = 0

    def act(self, belief: MovingBelief, viewpoint: int) -> Move:
        self.looks += 1
        return Move(self.looks // 2 % len(belief.belt.model.viewpoints))


class Described:
    """A classifier that keeps the descriptors of what it is given, with its class once that is known."""

    def __init__(self, classes: tuple[str, ...]) -> None:
        self.classes = classes
        self.config = PerceptionConfig()
        self.given: list[Histogram] = []
        self.descriptors: list[Histogram] = []
        self.labels: list[int] = []

    def classify(self, points: Points, camera: Points) -> Match:
        self.given.append(describe(points, camera, self.config))
        return Match(0, np.eye(len(self.classes))[0])


class Learner:
    """Perception that tells its classifier what the objects were."""

    def __init__(self, cell: ComposedMovingCell, perceive: TrackedPerception, described: Described) -> None:
        self.cell, self.perceive, self.described = cell, perceive, described

    @property
    def labels(self) -> Sequence[str]:
        return self.perceive.labels

    def __call__(self, scan: Scan, tracker: Tracker) -> TrackedScan:
        described = self.described
        described.given.clear()
        seen = self.perceive(scan, tracker)
        travel = tracker.motion.travel(seen.update.stamp).metres
        for look in (look for look in seen.looks if look.perceived.match is not None):
            descriptor = described.given.pop(0)
            label = self.cell.true_class_at(look.place + travel)
            if label is not None:
                described.descriptors.append(descriptor)
                described.labels.append(label)
        return seen


def cell_file(folder: Path, classifier: Path, model: Path) -> str:
    """Return the text of a cell file: the example's with irregular cups, a faster camera and these files."""
    text = example("moving").text
    prepare = text[text.index("# Classifier and tables") : text.index("[[viewpoints]]")]
    files = f'classifier = "{classifier.relative_to(folder)}"\nmodel = "{model.relative_to(folder)}"\n\n'
    for old, new in ((prepare, files), *CHANGES):
        assert text.count(old) == 1
        text = text.replace(old, new)
    return text


def described(cell_file: Path, seed: int) -> tuple[list[Histogram], list[int]]:
    """Return descriptors and class indices of the objects of a belt."""
    cell, belt, exposure = cell_of(cell_file, seed)
    keeps = Described(cell.classes)
    perceive = TrackedPerception(Perception(cell.layout, keeps), exposure)
    look_only(cell, Learner(cell, perceive, keeps), belt)
    return keeps.descriptors, keeps.labels


def surveyed(cell_file: Path, classifier: Classifier, seed: int) -> list[LooksAtObject]:
    """Return the looks at each object of a belt, in the order of the cups."""
    cell, belt, exposure = cell_of(cell_file, seed)
    perceive = TrackedPerception(Perception(cell.layout, classifier), exposure)
    return list(looks_at_objects(cell, look_only(cell, perceive, belt)))


def cell_of(cell_file: Path, seed: int) -> tuple[ComposedMovingCell, MovingBelt, float]:
    """Return the cell with the objects of a seed, its belt with any model, and the camera's exposure."""
    description = seeded(CellDescription.load(cell_file), OBJECTS, seed)
    moving = simulated_moving(description)
    cell = compose_moving(description, live=False, say=print)
    return cell, moving.belt(models.paper()), moving.exposure


def look_only(cell: ComposedMovingCell, perceive: PerceiveMoving, belt: MovingBelt) -> list[Entry]:
    """Let a belt pass under the camera, and return the journal."""
    with tempfile.TemporaryDirectory() as folder:
        with Journal(Path(folder) / JOURNAL) as journal:
            sort_moving(cell, perceive, Survey(), belt, journal, objects=OBJECTS)
        return read_journal(Path(folder) / JOURNAL)


def looks_at_objects(cell: ComposedMovingCell, entries: Iterable[Entry]) -> Iterator[LooksAtObject]:
    """Yield the looks at each object of a run, in the order of the cups."""
    spacing = cell.layout.spacing
    looks: dict[int, list[tuple[int, int, int | None]]] = defaultdict(list)
    true: dict[int, int | None] = {}
    for entry in entries:
        if not isinstance(entry.content, Looked):
            continue
        for each in entry.content.seen:
            if each.coordinate is None or each.finding == Finding.EMPTY:
                continue
            place = math.floor((each.coordinate - entry.content.travel) / spacing + 0.5)
            if 0 <= place < cell.layout.positions:
                looks[each.number].append((place, entry.content.viewpoint, each.label))
                true[each.number] = cell.true_class_at(each.coordinate)
    for number, its in sorted(looks.items()):
        label = true[number]
        if label is not None:
            yield LooksAtObject(label, tuple(its))


def estimated(cell: CellDescription, objects: Sequence[LooksAtObject]) -> tuple[SortingModel, SortingModel]:
    """Return models with one mode per class, and with latent modes."""
    names, number = cell.viewpoint_names, len(cell.classes)
    looks = RepeatedLooks.of(objects, TableShape(cell.layout.positions, len(names), number, number))
    counts = looks.first_counts() + UNIFORM_PRIOR
    one_mode = counts / counts.sum(axis=-1, keepdims=True)
    one = SortingModel(cell.classes, names, one_mode, r_min=R_MIN, discount=DISCOUNT)
    fitted = fit_modes(looks, MODES)
    weights = [list(each) for each in fitted.weights]
    modes = SortingModel(
        cell.classes,
        names,
        fitted.p_obs,
        modes=weights,
        labels=cell.classes,
        r_min=R_MIN,
        discount=DISCOUNT,
    )
    return one, modes


def main() -> None:
    """Train, estimate, and write the folder."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("moving"), metavar="FOLDER")
    parser.add_argument("--belts", type=int, default=40, help="belts for training, and as many for tables")
    given = parser.parse_args()
    folder: Path = given.output
    folder.mkdir(parents=True, exist_ok=True)
    classifier = folder / "classifier.npz"
    cells = {name: folder / f"{name}.toml" for name in ("one_mode", "modes", "standing")}
    for name, path in cells.items():
        its = folder / "standing.npz" if name == "standing" else classifier
        path.write_text(cell_file(folder, its, folder / f"{name}.json"), "utf-8")
    cell = cells["one_mode"]
    seeds = range(TRAINING_SEED, TRAINING_SEED + given.belts)
    descriptors, labels = zip(*in_processes(partial(described, cell), seeds, None, None), strict=True)
    trained = NearestNeighbour.train(
        list(chain(*descriptors)), list(chain(*labels)), CellDescription.load(cell).classes
    )
    trained.save(classifier)
    seeds = range(SURVEY_SEED, SURVEY_SEED + given.belts)
    objects = list(chain(*in_processes(partial(surveyed, cell, trained), seeds, None, None)))
    description = CellDescription.load(cell)
    standing = prepare()
    standing.database.save(folder / "standing.npz")
    known = standing.counts.model(description.classes, description.viewpoint_names, r_min=R_MIN)
    for name, model in zip(cells, (*estimated(description, objects), known), strict=True):
        model.save(folder / f"{name}.json")


if __name__ == "__main__":
    main()
