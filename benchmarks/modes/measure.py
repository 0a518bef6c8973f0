"""Log-loss and calibration of tables with and without modes, on looks that they were not fitted to."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from beltsort.tables import ModeSettings, RepeatedLooks, TableShape
from beltsort.tables.held_out import Candidate, log_posteriors
from beltsort.tables.mode_choice import MOST_MODES, candidates
from beltsort.tables.repeated_looks import NONE, Array, Integers, looks_in_every_row
from beltsort.util.calibration_error import calibration_error
from benchmarks.modes.collect import SimulatedLooks

SHARES = (1 / 3, 2 / 3, 1.0)  # 4, 8 and 12 of 12 looks at an object
ORDERS = 5  # random orders of the looks, over which figures are means
POSES = ("upright", "leaning", "lying")
LABELS = {"classes": 1, "classes with two confidence levels": 2}


@dataclass(frozen=True)
class Row:
    """How well one candidate predicts; tuples have an entry for each number of looks.

    Attributes
    ----------
    labels
        What the labels are: a key of `LABELS`.
    candidate
        How tables were fitted.
    kinds
        Kinds in a belief.
    looks
        Numbers of looks.
    log_loss, log_loss_error
        Of the true class, nats, and standard error.
    gain, gain_error
        Log-loss of one mode minus this one, of the same objects, and standard error.
    calibration_error
        Expected calibration error.
    right
        Share of objects whose most likely class is the true one.
    """

    labels: str
    candidate: str
    kinds: int
    looks: tuple[int, ...]
    log_loss: tuple[float, ...]
    log_loss_error: tuple[float, ...]
    gain: tuple[float, ...]
    gain_error: tuple[float, ...]
    calibration_error: tuple[float, ...]
    right: tuple[float, ...]


def confidence_levels(looks: SimulatedLooks, levels: int, fitted: slice) -> Integers:
    """Return labels with confidence levels: label * levels + level, shape (n, H, K, scans).

    The level is the quantile among the objects `fitted` of by how much the second-best class is farther away.
    """
    distances = np.sort(looks.distances, axis=-1)
    margin = distances[..., 1] - distances[..., 0]
    edges = np.nanquantile(margin[fitted], np.arange(1, levels) / levels)
    level = np.searchsorted(edges, margin)
    return np.where(looks.labels == NONE, NONE, looks.labels * levels + level)


def repeated(looks: SimulatedLooks, labels: Integers, number: int, *, named: bool = False) -> RepeatedLooks:
    """Return the looks as tables are fitted to them; `number` is the number of labels Z."""
    objects = looks_in_every_row(looks.true, labels, [POSES[pose] for pose in looks.pose] if named else None)
    shape = TableShape(labels.shape[1], labels.shape[2], int(looks.true.max()) + 1, number)
    return RepeatedLooks.of(objects, shape)


def measure(looks: SimulatedLooks, fitted: int, *, most: int = MOST_MODES) -> Iterator[Row]:
    """Fit every candidate to the first objects and predict the others, and the other way round.

    Parameters
    ----------
    looks
        The looks.
    fitted
        Objects to fit to; the same number is predicted. With fewer than twice as many objects, an error.
    most
        Largest number of modes.
    """
    if not 0 < 2 * fitted <= len(looks.true):
        raise ValueError(f"{len(looks.true)} objects, expected twice {fitted}: collect more")
    classes = int(looks.true.max()) + 1
    halves = (slice(0, fitted), slice(fitted, 2 * fitted))
    for name, levels in LABELS.items():
        pairs = []
        for fit, test in (halves, halves[::-1]):
            everything = repeated(looks, confidence_levels(looks, levels, fit), classes * levels, named=True)
            pairs.append(tuple(everything.of_objects(np.arange(2 * fitted)[part]) for part in (fit, test)))
        base: Array | None = None
        for candidate in candidates(pairs[0][0], ModeSettings(), most):
            kinds, posteriors, true = _predicted(candidate, pairs)
            losses = -posteriors[:, :, np.arange(len(true)), true].mean(axis=0)  # (shares, n)
            base = losses if base is None else base
            yield Row(
                name,
                candidate.name,
                kinds,
                tuple(round(share * looks.labels[0].size) for share in SHARES),
                *_mean(losses),
                *_mean(base - losses),
                _calibration_errors(posteriors, true),
                tuple((posteriors.argmax(axis=-1) == true).mean(axis=(0, 2)).tolist()),
            )


def _predicted(candidate: Candidate, pairs: list[tuple[RepeatedLooks, ...]]) -> tuple[int, Array, Integers]:
    """Return the kinds, the logarithms of the posteriors, (orders, shares, n, L), and the true classes."""
    kinds, posteriors, true = 0, [], []
    for fit, test in pairs:
        fitted = candidate.fit(fit)
        kinds = max(kinds, fitted.kinds)
        orders = [test.shuffled(seed) for seed in range(ORDERS)]
        posteriors.append([[log_posteriors(fitted, o.first(share)) for share in SHARES] for o in orders])
        true.append(test.true)
    return kinds, np.concatenate([np.array(each) for each in posteriors], axis=2), np.concatenate(true)


def _calibration_errors(log_posteriors: Array, true: Integers) -> tuple[float, ...]:
    errors = [[calibration_error(np.exp(each), true) for each in order] for order in log_posteriors]
    return tuple(np.mean(errors, axis=0).tolist())


def _mean(values: Array) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return means and standard errors over objects, shape (shares, n)."""
    error = values.std(axis=1, ddof=1) / np.sqrt(values.shape[1])
    return tuple(values.mean(axis=1).tolist()), tuple(error.tolist())
