"""Runs whose labels are drawn from tables, as the model assumes, and not from scans.

With the model's own tables as the truth, beliefs are calibrated up to chance. With true tables drawn from the
posterior of the counts, they show how much the tables' statistical error alone costs.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from beltsort import Belief, Decide, Despot, ModelError, SortingModel
from beltsort.calibration.sorted_runs import RUN_LENGTH, SortedRun, runs_of
from beltsort.planning.decisions import best_bin, probability_right
from beltsort.planning.named_policy import DEFAULT_TRIALS
from beltsort.planning.policy import Policy
from beltsort.sorting.rules import Rules
from beltsort.util.processes import Progress, in_processes
from beltsort.util.randomness import checked_seed, generator

SIMULATED_STREAM = 4  # of random numbers: see `beltsort.calibration.sorted_runs`

Array = NDArray[np.float64]


def simulate_runs(
    model: SortingModel,
    *,
    objects: int,
    seed: int = 0,
    uncertain: bool = False,
    truth: SortingModel | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> list[SortedRun]:
    """Sort objects whose labels are drawn from tables, planned by DESPOT.

    Parameters
    ----------
    model
        Updates the belief.
    objects, seed, workers, progress
        As in `beltsort.calibration.sorted_runs.sort_many`.
    uncertain
        Draw the true tables of each run from the Dirichlet posterior that the truth's counts leave.
    truth
        Draws the labels; default `model`.

    Raises
    ------
    ModelError
        If counts are needed and the truth has none.
    ArgumentError
        If `objects` or `workers` is below 1.
    """
    truth = truth or model
    if uncertain and (truth.counts is None or truth.smoothing is None):
        raise ModelError("the model has no counts, expected them with their smoothing: estimate it anew")
    task = partial(_simulated_run, model.to_json(), truth.to_json(), uncertain, checked_seed(seed))
    return list(in_processes(task, runs_of(objects), workers, progress))


def _simulated_run(model_text: str, truth_text: str, uncertain: bool, seed: int, number: int) -> SortedRun:
    model, truth = SortingModel.from_json(model_text), SortingModel.from_json(truth_text)
    rng = generator(seed, SIMULATED_STREAM, number)
    tables = truth.p_obs
    if uncertain:
        posterior = np.asarray(truth.counts, dtype=np.float64) + np.asarray(truth.smoothing, dtype=np.float64)
        gammas = rng.standard_gamma(posterior)  # normalised, they are draws from a Dirichlet distribution
        tables = gammas / gammas.sum(axis=-1, keepdims=True)
    run = _Run(model, truth, _Labels(tables, truth.repeat, rng), rng)
    return run.sorted(Despot(model, seed=number, trials=DEFAULT_TRIALS, threads=1))


class _Labels:
    """Draws labels; a repeated look may repeat the earlier label until the belt moves."""

    def __init__(self, tables: Array, repeat: Array, rng: np.random.Generator) -> None:
        self._tables, self._repeat, self._rng = tables, repeat, rng
        self._last: dict[tuple[int, int], int] = {}

    def of(self, position: int, viewpoint: int, kind: int) -> int:
        """Draw the label of one look at an object of a kind."""
        repeated = self._rng.random() < self._repeat[position, viewpoint]
        if not (repeated and (position, viewpoint) in self._last):
            shares = self._tables[position, viewpoint, kind]
            self._last[position, viewpoint] = int(self._rng.choice(len(shares), p=shares / shares.sum()))
        return self._last[position, viewpoint]

    def forget(self) -> None:
        """Forget the last labels, since the belt moves."""
        self._last.clear()


class _Run:
    """The loop of `beltsort.sorting.loop`, without cell and journal."""

    def __init__(
        self, model: SortingModel, truth: SortingModel, labels: _Labels, rng: np.random.Generator
    ) -> None:
        self._model, self._labels, self._belief = model, labels, Belief(model)
        self._viewpoint = 0
        places = RUN_LENGTH + model.positions - 1
        self._true = rng.choice(len(model.classes), size=places, p=model.arrival).tolist()
        self._kinds = [_kind_of(true, truth.modes, rng) for true in self._true]

    def sorted(self, policy: Policy) -> SortedRun:
        """Sort all objects."""
        beliefs: list[tuple[int, tuple[float, ...]]] = []
        decisions: list[tuple[int, int | None, float]] = []
        moves = 0
        for first in range(RUN_LENGTH):
            for _ in range(Rules().max_looks):
                action = policy.act(self._belief.copy(), self._viewpoint)
                if isinstance(action, Decide):
                    bin = action.bin
                    break
                moves += 1
                self._viewpoint = action.viewpoint
                self._look(first)
                rows = enumerate(self._belief.probabilities.tolist(), start=first)
                beliefs += [(number, tuple(row)) for number, row in rows if number < RUN_LENGTH]
            else:
                bin = best_bin(self._belief)
            decisions.append((first, bin, probability_right(self._belief, bin)))
            self._belief.advance()
            self._labels.forget()
        true = self._true[:RUN_LENGTH]
        return SortedRun.of(self._model, true, moves + len(decisions), decisions, beliefs)

    def _look(self, first: int) -> None:
        seen = [
            self._labels.of(position, self._viewpoint, self._kinds[first + position])
            for position in range(self._model.positions)
        ]
        self._belief.observe(self._viewpoint, seen)


def _kind_of(true: int, modes: Sequence[Sequence[float]], rng: np.random.Generator) -> int:
    """Draw the mode of an object; return its kind."""
    weights = modes[true]
    before = sum(len(others) for others in modes[:true])
    # A class of one mode draws no random number: runs of models without modes stay as they are.
    if len(weights) == 1:
        return before
    return before + int(rng.choice(len(weights), p=np.divide(weights, sum(weights))))
