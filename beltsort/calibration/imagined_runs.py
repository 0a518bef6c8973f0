"""Sort objects whose labels are drawn from tables: what runs would believe if looks were as modelled.

With the model's own tables as the truth, beliefs are calibrated but for chance; with tables drawn from what
the counts leave open, they are wrong by as much as counting so few objects makes them.
"""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from beltsort import Belief, Decide, Despot, ModelError, SortingModel
from beltsort.calibration.sorted_runs import RUN_LENGTH, TRIALS, SortedRun, runs_of
from beltsort.planning.policy import Policy
from beltsort.sorting.rules import Rules
from beltsort.util.processes import Progress, in_processes
from beltsort.util.randomness import checked_seed, generator

IMAGINED_STREAM = 4  # of random numbers: see `beltsort.calibration.sorted_runs`

Array = NDArray[np.float64]


def imagine(
    model: SortingModel,
    *,
    objects: int,
    seed: int = 0,
    uncertain: bool = False,
    truth: SortingModel | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> list[SortedRun]:
    """Sort imagined objects, planned by DESPOT.

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
    task = partial(_imagined, model.to_json(), truth.to_json(), uncertain, checked_seed(seed))
    return list(in_processes(task, runs_of(objects), workers, progress))


def _imagined(model_text: str, truth_text: str, uncertain: bool, seed: int, number: int) -> SortedRun:
    model, truth = SortingModel.from_json(model_text), SortingModel.from_json(truth_text)
    rng = generator(seed, IMAGINED_STREAM, number)
    tables = _posterior_draw(truth, rng) if uncertain else truth.p_obs
    run = _Run(model, _Labels(tables, truth.repeat, rng), rng)
    return run.sorted(Despot(model, seed=number, trials=TRIALS, threads=1))


def _posterior_draw(truth: SortingModel, rng: np.random.Generator) -> Array:
    """Draw tables from the Dirichlet posterior of each row, shape (H, K, L, L)."""
    gammas = rng.standard_gamma(np.asarray(truth.counts, dtype=np.float64) + float(truth.smoothing or 0.0))
    tables: Array = gammas / gammas.sum(axis=-1, keepdims=True)
    return tables


class _Labels:
    """Draws labels; a repeated look may repeat its label until the belt moves."""

    def __init__(self, tables: Array, repeat: Array, rng: np.random.Generator) -> None:
        self._tables, self._repeat, self._rng = tables, repeat, rng
        self._last: dict[tuple[int, int], int] = {}

    def of(self, position: int, viewpoint: int, true: int) -> int:
        """Draw the label of one look."""
        repeated = self._rng.random() < self._repeat[position, viewpoint]
        if not (repeated and (position, viewpoint) in self._last):
            shares = self._tables[position, viewpoint, true]
            self._last[position, viewpoint] = int(self._rng.choice(len(shares), p=shares / shares.sum()))
        return self._last[position, viewpoint]

    def forget(self) -> None:
        """Forget the last labels, since the belt moves."""
        self._last.clear()


class _Run:
    """The loop of `beltsort.sorting.loop`, without cell and journal."""

    def __init__(self, model: SortingModel, labels: _Labels, rng: np.random.Generator) -> None:
        self._model, self._labels, self._belief = model, labels, Belief(model)
        self._viewpoint = 0
        places = RUN_LENGTH + model.positions - 1
        self._true = rng.choice(len(model.classes), size=places, p=model.arrival).tolist()

    def sorted(self, policy: Policy) -> SortedRun:
        """Sort all objects."""
        beliefs: list[tuple[int, tuple[float, ...]]] = []
        decisions: list[tuple[int, int, float]] = []
        moves = 0
        for first in range(RUN_LENGTH):
            for _ in range(Rules().max_looks):
                action = policy.act(self._belief.copy(), self._viewpoint)
                if isinstance(action, Decide):
                    break
                moves += 1
                self._viewpoint = action.viewpoint
                self._look(first)
                rows = enumerate(self._belief.probabilities.tolist(), start=first)
                beliefs += [(number, tuple(row)) for number, row in rows if number < RUN_LENGTH]
            label, belief = self._belief.most_likely(0)
            decisions.append((first, label, belief))
            self._belief.advance()
            self._labels.forget()
        true = tuple(self._true[:RUN_LENGTH])
        return SortedRun(true, moves + len(decisions), tuple(decisions), tuple(beliefs))

    def _look(self, first: int) -> None:
        seen = [
            self._labels.of(position, self._viewpoint, self._true[first + position])
            for position in range(self._model.positions)
        ]
        self._belief.observe(self._viewpoint, seen)
