"""A classifier and labelled scans from the simulated cell; `beltsort.sim.rounds` describes the scenes."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeAlias

from beltsort.perception import (
    Classifier,
    NearestNeighbour,
    Perceived,
    Perception,
    PerceptionConfig,
    describe,
    segment,
)
from beltsort.perception.classifier import check_classes
from beltsort.perception.finding import Finding
from beltsort.perception.vfh import Histogram
from beltsort.sim import CellConfig
from beltsort.sim.config import TABLE_OBJECTS, TRAINING_OBJECTS
from beltsort.sim.rounds import TABLE_STREAM, TRAINING_STREAM, Round, Scenes, passages_of, rounds_of
from beltsort.tables.counts import Counts, count
from beltsort.tables.log import LabelLog, PositionLabel, PositionLabels, label_missing
from beltsort.tables.matches import MatchedScan, Matches, MatchLog, Seen
from beltsort.tables.scans import LabelledScan, looks
from beltsort.util.keyed_log import KeyedLog
from beltsort.util.processes import Progress, in_processes

SCANS = 2  # scans of each scene for the tables, from one viewpoint


def collect_training(
    config: CellConfig | None = None,
    perception: PerceptionConfig | None = None,
    *,
    objects: int = TRAINING_OBJECTS,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> NearestNeighbour:
    """Train a classifier on objects of the simulated cell.

    Processes are spawned and import the main module again, so a script must call this under
    `if __name__ == "__main__":`.

    Parameters
    ----------
    config, perception
        Configuration of the cell, and settings of perception.
    objects
        Objects of each class at each viewpoint and position. With too few, rare poses have no similar entry;
        the time is proportional to the number.
    seed
        Seed, at least 0. `collect_counts` with the same seed uses other objects.
    workers
        Processes, at least 1; default one for each core that this process may use. With 1 the work is done in
        this process.
    progress
        Called with the number of rounds done and the total number.

    Returns
    -------
    NearestNeighbour
        Up to K * H * L * `objects` descriptors; objects that perception does not find are omitted.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    BeltsortError
        If a worker process dies.
    """
    config, perception = config or CellConfig(), perception or PerceptionConfig()
    views = training_views(config, perception, objects=objects, seed=seed, workers=workers, progress=progress)
    return NearestNeighbour.train(views.descriptors, views.labels, config.classes, perception)


class TrainingViews(NamedTuple):
    """Scans of objects for training.

    Attributes
    ----------
    labels, descriptors
        Class index and descriptor of each object that perception finds.
    missed
        How often it found something else where an object stood.
    """

    labels: list[int]
    descriptors: list[Histogram]
    missed: Counter[Finding]


def training_views(
    config: CellConfig,
    perception: PerceptionConfig,
    *,
    objects: int,
    seed: int,
    workers: int | None,
    progress: Progress | None,
) -> TrainingViews:
    """Scan the objects that `collect_training` trains on; parameters and raises as there."""
    rounds = rounds_of(TRAINING_STREAM, seed, config, objects)
    views = TrainingViews([], [], Counter())
    for of_round in in_processes(partial(_described, config, perception), rounds, workers, progress):
        views.labels.extend(of_round.labels)
        views.descriptors.extend(of_round.descriptors)
        views.missed.update(of_round.missed)
    return views


def _described(config: CellConfig, perception: PerceptionConfig, work: Round) -> TrainingViews:
    """Return what the scans of a round show."""
    views = TrainingViews([], [], Counter())
    for truth, (scan,) in zip(work.truths(config), work.scans(config, number=1), strict=True):
        segmented = segment(scan, config.layout, perception)
        seen = zip(truth.true, segmented.objects, segmented.findings, strict=True)
        for label, points, finding in seen:
            if label is None:
                continue
            if points is None:
                views.missed[finding] += 1
                continue
            views.labels.append(label)
            views.descriptors.append(describe(points, segmented.camera, perception))
    return views


def collect_counts(
    database: Classifier,
    config: CellConfig | None = None,
    *,
    objects: int = TABLE_OBJECTS,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Counts:
    """Count the labels of independent objects in every table row.

    As with `collect_training`, a script must call this under `if __name__ == "__main__":`.

    Parameters
    ----------
    database
        The classifier, with the settings of perception with which it was trained.
    config
        Configuration of the cell.
    objects
        Objects in each row (position, viewpoint, true class), each scanned twice. The standard error of an
        entry p is sqrt(p (1 - p) / objects).
    seed, workers, progress
        As in `collect_training`.

    Raises
    ------
    DatabaseError
        If the classifier has other classes than the cell, or in another order.
    ArgumentError
        If `objects` or `workers` is below 1.
    BeltsortError
        If a worker process dies.
    """
    config = config or CellConfig()
    scans = collect_scans(database, config, objects=objects, seed=seed, workers=workers, progress=progress)
    return count(looks(scans), config.layout.positions, len(config.viewpoints), len(config.classes))


def table_scenes(config: CellConfig, *, objects: int, seed: int, passages: bool = False) -> Sequence[Scenes]:
    """Return the scenes in which labels are counted.

    Parameters
    ----------
    config
        Configuration of the cell.
    objects
        Objects in each table row; with passages rounded up to a multiple of `OBJECTS_OF_A_CLASS`.
    seed
        At least 0.
    passages
        Whether each object is in all rows of its class, and not in one only. Such looks tell how those at one
        object depend on each other, and take about as many scans.
    """
    return passages_of(seed, objects) if passages else rounds_of(TABLE_STREAM, seed, config, objects)


def collect_scans(
    database: Classifier,
    config: CellConfig | None = None,
    *,
    objects: int = TABLE_OBJECTS,
    seed: int = 0,
    passages: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    log: LabelLog | None = None,
) -> list[LabelledScan]:
    """Label two scans of every scene that `collect_counts` counts, or of passages.

    Parameters
    ----------
    database, config, objects, seed, workers, progress
        As in `collect_counts`.
    passages
        As in `table_scenes`.
    log
        Log to which the labels of each piece of work are written; scans that are in it are not labelled
        again.

    Raises
    ------
    RecordingError
        If the log cannot be written.
    DatabaseError, ArgumentError, BeltsortError
        As `collect_counts`.
    """
    config = config or CellConfig()
    check_classes(database, config.classes, "the cell's")
    scenes = table_scenes(config, objects=objects, seed=seed, passages=passages)
    log = log or LabelLog()
    _perceive(partial(_labelled, config, database), config, scenes, log, workers, progress)
    known = log.positions()
    return [
        LabelledScan(
            *where,
            tuple(position.label for position in known[name]),
            tuple(position.finding for position in known[name]),
            known[name][0].pose_fault,
        )
        for name, where in _scans_of(scenes, config)
    ]


def collect_matches(
    database: Classifier,
    config: CellConfig | None = None,
    *,
    objects: int = TABLE_OBJECTS,
    seed: int = 0,
    passages: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    log: MatchLog | None = None,
) -> list[MatchedScan]:
    """Classify the scans that `collect_scans` labels, and keep all that the classifier returns.

    Parameters and raises as `collect_scans`.
    """
    config = config or CellConfig()
    check_classes(database, config.classes, "the cell's")
    scenes = table_scenes(config, objects=objects, seed=seed, passages=passages)
    log = log or MatchLog()
    _perceive(partial(_matched, config, database), config, scenes, log, workers, progress)
    known = log.matches()
    return [MatchedScan(*where, known[name]) for name, where in _scans_of(scenes, config)]


def _perceive(
    task: Callable[[Scenes], Mapping[str, Any]],
    config: CellConfig,
    scenes: Sequence[Scenes],
    log: KeyedLog,
    workers: int | None,
    progress: Progress | None,
) -> None:
    """Write what `task` returns of every piece of work to the log."""
    label_missing(task, scenes, lambda work: work.scan_names(config, SCANS), log, workers, progress)


def _labelled(config: CellConfig, database: Classifier, work: Scenes) -> PositionLabels:
    """Return what is kept of all scans by the scan's name, `SCANS` of each scene."""
    perceived = _perceived(config, database, work)
    return {name: tuple(map(PositionLabel.of, positions)) for name, positions in perceived}


def _matched(config: CellConfig, database: Classifier, work: Scenes) -> Matches:
    """Return what is seen in all scans by the scan's name, `SCANS` of each scene."""
    return {name: tuple(map(Seen.of, perceived)) for name, perceived in _perceived(config, database, work)}


def _perceived(
    config: CellConfig, database: Classifier, work: Scenes
) -> Iterator[tuple[str, list[Perceived]]]:
    """Yield the name of every scan, and what is perceived in it."""
    perceive = Perception(config.layout, database)
    scans = (scan for of_scene in work.scans(config, SCANS) for scan in of_scene)
    for name, scan in zip(work.scan_names(config, SCANS), scans, strict=True):
        yield name, perceive(scan)


Where: TypeAlias = tuple[int, tuple[int | None, ...], tuple[str | None, ...]]
"""Viewpoint, true classes and objects of a scan."""


def _scans_of(scenes: Sequence[Scenes], config: CellConfig) -> Iterator[tuple[str, Where]]:
    """Yield the name of every scan, and what it is of."""
    for work in scenes:
        names = iter(work.scan_names(config, SCANS))
        for truth in work.truths(config):
            for _ in range(SCANS):
                yield next(names), (truth.viewpoint, truth.true, truth.objects)
