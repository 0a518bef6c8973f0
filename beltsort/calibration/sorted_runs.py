"""Sort many objects from simulated depth scans, and keep every belief with the true class.

A run is one simulated cell of its own, `objects` to be sorted and others behind them, so that no position is
ever empty. What a run's objects are, how they lie, and the noise of the n-th scan since the belt moved depend
on its seed only: models that are compared, the *arms*, sort the same objects in the same noise as long as
they look from the same viewpoints.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from beltsort import ArgumentError, Despot, SortingModel
from beltsort.calibration.reliability import Pairs
from beltsort.perception import Classifier, perception_for
from beltsort.perception.classifier import check_classes
from beltsort.planning.decisions import right_bins
from beltsort.planning.named_policy import DEFAULT_TRIALS
from beltsort.sim import CellConfig
from beltsort.sorting.entries import Decided, Scanned
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.progress import Progress
from beltsort.sorting.report import confusion
from beltsort.util import processes
from beltsort.util.processes import at_least_one, in_processes
from beltsort.util.randomness import checked_seed, generator

RUN_LENGTH = 10  # objects, as in the paper
CALIBRATION_STREAM = 2  # neither trained on nor counted: see `beltsort.sim.rounds`


@dataclass(frozen=True)
class SortedRun:
    """The beliefs of a run, and the true classes.

    Attributes
    ----------
    true
        Class index of each object sorted.
    steps
        Moves and decisions.
    decisions
        (object, bin, probability that the bin is right) of each; the bin is None for the reject bin.
    right
        Whether each decision is right: no bin is worth more for the object's class.
    confusion
        Number of objects by bin and true class, shape (B, L).
    beliefs
        (object, probabilities of all classes) after each scan for each position.
    """

    true: tuple[int, ...]
    steps: int
    decisions: tuple[tuple[int, int | None, float], ...]
    right: tuple[bool, ...]
    confusion: tuple[tuple[int, ...], ...]
    beliefs: tuple[tuple[int, tuple[float, ...]], ...]

    @classmethod
    def of(
        cls,
        model: SortingModel,
        true: Sequence[int],
        steps: int,
        decisions: Sequence[tuple[int, int | None, float]],
        beliefs: Sequence[tuple[int, tuple[float, ...]]],
    ) -> "SortedRun":
        """Return a run whose decisions are compared with the true classes; parameters as the attributes."""
        right = right_bins(model)
        counts = confusion([(number, bin) for number, bin, _ in decisions], true.__getitem__, model)
        return cls(
            tuple(true),
            steps,
            tuple(decisions),
            tuple(bin is not None and bool(right[bin, true[number]]) for number, bin, _ in decisions),
            tuple(map(tuple, counts.tolist())),
            tuple(beliefs),
        )

    @property
    def correct(self) -> int:
        """Number of right decisions."""
        return sum(self.right)


def run_in(entries: Sequence[Entry], true: Sequence[int]) -> SortedRun:
    """Return what a journal holds of a run's beliefs.

    Parameters
    ----------
    entries
        Of the whole run.
    true
        Class index of each object that was to be sorted; beliefs about further ones are left out.
    """
    beliefs: list[tuple[int, tuple[float, ...]]] = []
    decisions: list[tuple[int, int | None, float]] = []
    for entry in entries:
        first = entry.object or 0
        match entry.content:
            case Scanned(belief=belief):
                rows = enumerate(belief, start=first)
                beliefs += [(number, tuple(row)) for number, row in rows if number < len(true)]
            case Decided(label, belief=probability):
                decisions.append((first, label, probability))
    progress = Progress.after(entries)
    return SortedRun.of(progress.model, true, progress.steps, decisions, beliefs)


def sort_many(
    models: Sequence[SortingModel],
    database: Classifier,
    config: CellConfig | None = None,
    *,
    objects: int,
    seed: int = 0,
    workers: int | None = None,
    progress: processes.Progress | None = None,
) -> list[list[SortedRun]]:
    """Sort objects of all classes with each of the models, planned by DESPOT.

    As with `beltsort.sim.collect.collect_training`, a script calls this under `if __name__ == "__main__":`.

    Parameters
    ----------
    models
        The arms, for the cell's classes, viewpoints and positions, all with one arrival prior.
    database
        The classifier.
    config
        What the cell is set to.
    objects
        Objects that each arm sorts, drawn from the arrival prior; rounded up to whole runs of `RUN_LENGTH`.
    seed
        Not negative.
    workers, progress
        As in `beltsort.sim.collect.collect_counts`.

    Returns
    -------
    list
        The runs of each arm.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1, or the models cannot be compared.
    BeltsortError
        Whatever the loop raises.
    """
    _check_arms(models)
    config = config or CellConfig()
    check_classes(database, config.classes, "the cell's")
    texts = [model.to_json() for model in models]
    work = [(text, number) for number in runs_of(objects) for text in texts]
    task = partial(_sorted, config, database, checked_seed(seed))
    runs = list(in_processes(task, work, workers, progress))
    return [runs[arm :: len(texts)] for arm in range(len(texts))]


def runs_of(objects: int) -> range:
    """Return the numbers of the runs in which so many objects are sorted."""
    return range(-(-at_least_one("objects", objects) // RUN_LENGTH))


def _check_arms(models: Sequence[SortingModel]) -> None:
    # Weights of modes may sum to 1 but for rounding.
    if not models or any(not np.allclose(model.arrival, models[0].arrival, atol=1e-9) for model in models):
        raise ArgumentError(
            f"{len(models)} models with different arrival priors or none at all, expected at least one, all "
            "with the same prior: the objects are drawn from it"
        )
    if any(model.empty is not None for model in models):
        raise ArgumentError("a model has a class for empty cups, of which there are none here; leave it out")


def _sorted(config: CellConfig, database: Classifier, seed: int, work: tuple[str, int]) -> SortedRun:
    """Sort the objects of one run."""
    from beltsort.sim import SimulatedCell

    text, number = work
    model, rng = SortingModel.from_json(text), generator(seed, CALIBRATION_STREAM, number)
    places = RUN_LENGTH + config.layout.positions - 1 + config.upstream
    true = rng.choice(len(model.classes), size=places, p=model.arrival).tolist()
    cell = SimulatedCell(true, config, int(rng.integers(2**63)), bin_names=model.bins)
    perceive = perception_for(model, config.layout, database)
    planner = Despot(model, seed=number, trials=DEFAULT_TRIALS, threads=1)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "journal.sqlite"
        with Journal(path) as journal:
            sort_objects(cell, perceive, planner, model, journal, objects=RUN_LENGTH)
        return run_in(read_journal(path), true[:RUN_LENGTH])


def decision_pairs(runs: Sequence[SortedRun]) -> Pairs:
    """Return the probability that each decision is right, and whether it was."""
    rows = [
        (belief, right, n * RUN_LENGTH + number)
        for n, run in enumerate(runs)
        for (number, _, belief), right in zip(run.decisions, run.right, strict=True)
    ]
    beliefs, true, objects = zip(*rows, strict=True)
    return Pairs(np.array([beliefs]).T, np.array([true]).T, objects, RUN_LENGTH * len(runs))


def step_pairs(runs: Sequence[SortedRun]) -> Pairs:
    """Return the belief in every class after each scan for each position, and which was true."""
    rows = [
        (row, np.arange(len(row)) == run.true[number], n * RUN_LENGTH + number)
        for n, run in enumerate(runs)
        for number, row in run.beliefs
    ]
    beliefs, true, objects = zip(*rows, strict=True)
    return Pairs(beliefs, np.stack(true), objects, RUN_LENGTH * len(runs))
