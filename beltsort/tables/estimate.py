"""Estimation of a model from labelled scans, with standard errors and tests of its assumptions."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

import beltsort
from beltsort.perception.label_rule import LabelRule
from beltsort.tables.counts import Array, Counts, count
from beltsort.tables.independence import REPEAT, IndependenceTest, independence
from beltsort.tables.intervals import (
    WorstRow,
    credible_intervals,
    objects_needed,
    standard_errors,
    worst_row,
)
from beltsort.tables.modes import ModeTables
from beltsort.tables.pooling import pooled_prior
from beltsort.tables.scans import LabelledScan, looks
from beltsort.util.defaults import TARGET_ERROR
from beltsort.util.html import box, caption, table
from beltsort.util.text import counted, number_or_none, position_number, text_table

SIGNIFICANT = 0.05  # after Holm's correction
ACCURACY = "share of right labels, mean over the classes"


@dataclass(frozen=True, eq=False)
class Estimate:
    """A model estimated from labelled scans, and its statistics.

    Attributes
    ----------
    model
        The model; it includes counts and smoothing unless it has modes.
    counts
        Label counts of independent objects, by class.
    smoothing
        Pseudo-counts of the prior: one number, or one for each entry, shape (H, K, L, Z).
    scans
        Number of scans.
    worst
        The table row with the largest standard error.
    missing
        Further objects needed per row for every entry to have at most the target standard error.
    tests
        Tests of the model's assumptions.
    """

    model: "beltsort.SortingModel"
    counts: Counts
    smoothing: float | Array
    scans: int
    worst: WorstRow
    missing: int
    tests: list[IndependenceTest]

    def __repr__(self) -> str:
        """Return the accuracy of looks by position and viewpoint, the largest error, and warnings."""
        return "\n".join(
            [f"{self._title()}, {ACCURACY}", text_table([self._header(), *self._rows()]), *self._remarks()]
        )

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        shades = np.nan_to_num(self.counts.accuracy()).tolist()
        accuracy = table(self._rows(), header=self._header(), shades=shades)
        return box(self._title(), caption(ACCURACY), accuracy, remark=" ".join(self._remarks()))

    def _title(self) -> str:
        return f"Estimate from {counted(self.scans, 'scan')}"

    def _header(self) -> list[str]:
        return ["position", *self.model.viewpoints]

    def _rows(self) -> list[list[str]]:
        accuracy = self.counts.accuracy()
        return [[position_number(j), *(f"{share:.3f}" for share in row)] for j, row in enumerate(accuracy)]

    def _remarks(self) -> list[str]:
        """Return sentences on the largest standard error and on what is doubtful."""
        worst = self.worst
        error = (
            f"Largest standard error {worst.error:.3f}: position {position_number(worst.position)}, "
            f"{self.model.viewpoints[worst.viewpoint]}, true {self.model.classes[worst.true]}, "
            f"{counted(worst.objects, 'object')}."
        )
        return [error, *(f"Warning: {warning}." for warning in self.warnings())]

    def warnings(self) -> list[str]:
        """Return sentences on table rows without any object, and on assumptions that the scans contradict."""
        warnings = [self._warning(test) for test in self.tests if test.p <= SIGNIFICANT]
        per_row = self.counts.counts.sum(axis=-1)
        if empty := int((per_row == 0).sum()):
            rows = f"{empty} of {per_row.size} table rows"
            warnings.insert(0, f"{rows} have no labelled object: they are the prior alone")
        return warnings

    def _warning(self, test: IndependenceTest) -> str:
        """Return a sentence on an assumption that a test rejects."""
        where = " and ".join(position_number(j) for j in test.positions)
        details = f"p = {test.p:.4f}, {test.scans} scans"
        view = self.model.viewpoints[test.viewpoint]
        if test.assumption == REPEAT:
            repeat = self.counts.repeat()[test.positions[0], test.viewpoint]
            if any(len(weights) > 1 for weights in self.model.modes):
                remedy = ", which the modes of the model carry"
            else:
                remedy = (
                    "" if self.model.repeat.any() else "; --modes auto or --repeats puts it into the model"
                )
            return (
                f"position {where} from {view}: two scans of one object agree more often than two objects "
                f"({test.excess:+.3f}, {details}); a second look repeats the first with probability "
                f"{repeat:.2f}{remedy}"
            )
        return (
            f"positions {where} from {view}: {test.assumption} depend on each other "
            f"({test.excess:+.3f} nats, {details}); the model takes them for independent"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON."""
        lower, upper = credible_intervals(self.counts, self.smoothing)
        return {
            "classes": self.model.classes,
            "viewpoints": self.model.viewpoints,
            "labels": self.model.labels,
            "scans": self.scans,
            "smoothing": np.asarray(self.smoothing).tolist(),
            "counts": self.counts.counts.tolist(),
            "missed": self.counts.missed.tolist(),
            "p_obs": self.model.p_obs.tolist(),
            "mode_weights": self.model.modes,
            "standard_errors": standard_errors(self.counts, self.smoothing).tolist(),
            "lower": lower.tolist(),
            "upper": upper.tolist(),
            "repeat": [[number_or_none(share) for share in row] for row in self.counts.repeat().tolist()],
            "worst_row": asdict(self.worst),
            "missing_objects": self.missing,
            "independence": [asdict(test) for test in self.tests],
            "warnings": self.warnings(),
        }


def estimate(
    scans: Sequence[LabelledScan],
    classes: Sequence[str],
    viewpoints: Sequence[str],
    *,
    smoothing: float | Array | None = None,
    repeats: bool = False,
    error: float = TARGET_ERROR,
    note: str = "",
    rule: LabelRule | None = None,
    modes: ModeTables | None = None,
) -> Estimate:
    """Estimate a model from labelled scans.

    Parameters
    ----------
    scans
        The scans, at least one.
    classes, viewpoints
        Names of the classes and viewpoints.
    smoothing
        Pseudo-counts of the prior, as in `Counts.probabilities`; default: `pooled_prior` of the counts.
    repeats
        As in `Counts.model`.
    error
        Target standard error of every entry; a 95 % interval extends about two standard errors to each side.
    note
        The model's note.
    rule
        The rule that the scans are labelled with, which the model keeps; default: the labels are the classes.
    modes
        Tables of the modes of the classes, fitted to the same scans, for the model; default: one mode each.
        The statistics are those of the classes all the same.

    Returns
    -------
    Estimate
        The model and its statistics.

    Raises
    ------
    ArgumentError
        If there is no scan, `smoothing` is not positive, or `error` is not between 0 and 1.

    Examples
    --------
    >>> scans = [LabelledScan(0, (i % 2,), (f"object {i}",), (i % 2,)) for i in range(20)]
    >>> result = estimate(scans, ["nut", "bolt"], ["above"], error=0.02)
    >>> result.model.p_obs[0, 0].round(3).tolist()
    [[0.989, 0.011], [0.011, 0.989]]
    >>> result.missing
    15
    """
    if not scans:
        raise beltsort.ArgumentError("there are 0 labelled scans, expected at least one: scan some objects")
    shape = len(scans[0].true), len(viewpoints), len(classes)
    counts = count(looks(scans), *shape, None if rule is None else rule.label_classes)
    labels: dict[str, Any] = {} if rule is None else {"labels": rule.labels, "label_rule": rule.to_dict()}
    if smoothing is None:
        smoothing = pooled_prior(counts)
    if modes is None or modes.kinds == len(classes):
        model = counts.model(classes, viewpoints, smoothing=smoothing, repeats=repeats, note=note, **labels)
    elif repeats:
        raise beltsort.ArgumentError(
            "repeats and modes are both given; modes carry how looks depend on each other: leave repeats out"
        )
    else:
        labels["modes"] = [list(each) for each in modes.weights]
        model = beltsort.SortingModel(classes, viewpoints, modes.p_obs, note=note, **labels)
    return Estimate(
        model,
        counts,
        smoothing,
        len(scans),
        worst_row(counts, smoothing, error),
        int(objects_needed(counts, smoothing, error).max()),
        independence(scans),
    )
