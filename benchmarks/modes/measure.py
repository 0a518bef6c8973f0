"""Log-loss and calibration of tables with and without modes, on looks that they were not fitted to."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from beltsort.perception.label_edges import fit_label_rule
from beltsort.perception.label_rule import LabelRule
from beltsort.tables import MatchedScan, ModeSettings, RepeatedLooks, TableShape, looks_at_objects
from beltsort.tables.held_out import Candidate, log_posteriors
from beltsort.tables.mode_choice import MOST_MODES, candidates
from beltsort.tables.repeated_looks import Array, Integers
from beltsort.util.calibration_error import calibration_error

SHARES = (1 / 3, 2 / 3, 1.0)  # 4, 8 and 12 of 12 looks at an object
ORDERS = 5  # random orders of the looks, over which figures are means
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


@dataclass(frozen=True, eq=False)
class Matched:
    """Scans of objects that were all looked at equally often.

    Attributes
    ----------
    scans
        From `beltsort.sim.collect.collect_matches`, of passages.
    classes
        Names of the classes.
    viewpoints
        K.
    poses
        How each object lies, by its name.
    """

    scans: Sequence[MatchedScan]
    classes: tuple[str, ...]
    viewpoints: int
    poses: Mapping[str, str]

    def rule(self, levels: int, objects: set[str]) -> LabelRule:
        """Return the rule whose levels are equally frequent in scans of the named objects."""
        seen = [
            (position.match, true)
            for scan in self.scans
            for position, true, name in zip(scan.seen, scan.true, scan.objects, strict=True)
            if name in objects and position.match is not None and true is not None
        ]
        return fit_label_rule(self.classes, [m for m, _ in seen], [true for _, true in seen], levels)

    def looks(self, rule: LabelRule) -> RepeatedLooks:
        """Return the looks as tables are fitted to them, the objects in the order of `poses`."""
        positions = len(self.scans[0].true)
        shape = TableShape(positions, self.viewpoints, len(self.classes), len(rule.labels))
        scans = [scan.labelled(rule) for scan in self.scans]
        return RepeatedLooks.of(looks_at_objects(scans, self.poses), shape)


def measure(matched: Matched, fitted: int, *, most: int = MOST_MODES) -> Iterator[Row]:
    """Fit every candidate to the first objects and predict the others, and the other way round.

    Parameters
    ----------
    matched
        The scans.
    fitted
        Objects to fit to; the same number is predicted. With fewer than twice as many objects, an error.
    most
        Largest number of modes.
    """
    names = list(matched.poses)
    if not 0 < 2 * fitted <= len(names):
        raise ValueError(f"{len(names)} objects, expected twice {fitted}: collect more")
    halves = (slice(0, fitted), slice(fitted, 2 * fitted))
    for name, levels in LABELS.items():
        pairs = []
        for fit, test in (halves, halves[::-1]):
            everything = matched.looks(matched.rule(levels, set(names[fit])))
            pairs.append(tuple(everything.of_objects(np.arange(2 * fitted)[part]) for part in (fit, test)))
        looks = round(len(everything.objects) / len(everything))
        base: Array | None = None
        for candidate in candidates(pairs[0][0], ModeSettings(), most):
            kinds, posteriors, true = _predicted(candidate, pairs)
            losses = -posteriors[:, :, np.arange(len(true)), true].mean(axis=0)  # (shares, n)
            base = losses if base is None else base
            yield Row(
                name,
                candidate.name,
                kinds,
                tuple(round(share * looks) for share in SHARES),
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
