"""Which class is taken for which."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsort.perception.classifier import Match
from beltsort.util.text import text_table


@dataclass(frozen=True, eq=False)
class Confusion:
    """Counts of answers.

    Attributes
    ----------
    classes
        Names of the L classes.
    counts
        Row: true class, column: label, the last one for no label; shape (L, L + 1).

    Examples
    --------
    >>> answers = [Match(label, np.ones(2)) for label in (0, 1, 1, None)]
    >>> print(confusion([0, 0, 1, 1], answers, ["bulb", "cup"]))
      true  bulb  cup  none   right
      bulb     1    1     0  50.0 %
      cup      0    1     1  50.0 %
    """

    classes: tuple[str, ...]
    counts: NDArray[np.int64]

    @property
    def right(self) -> int:
        """Number of right labels."""
        return int(np.trace(self.counts))

    @property
    def total(self) -> int:
        """Number of answers."""
        return int(self.counts.sum())

    @property
    def recall(self) -> NDArray[np.float64]:
        """Share of each class that is labelled right, shape (L,); NaN for a class without an answer."""
        with np.errstate(invalid="ignore"):
            shares: NDArray[np.float64] = np.diagonal(self.counts) / self.counts.sum(axis=1)
        return shares

    def __str__(self) -> str:
        """Return the counts as a table."""
        shares = [f"{100.0 * share:.1f} %" for share in self.recall]
        rows = [
            [name, *map(str, row), share]
            for name, row, share in zip(self.classes, self.counts, shares, strict=True)
        ]
        return text_table([["true", *self.classes, "none", "right"], *rows])


def confusion(true_labels: Iterable[int], matches: Sequence[Match], classes: Sequence[str]) -> Confusion:
    """Count answers.

    Parameters
    ----------
    true_labels
        Class index of each answered candidate.
    matches
        The answers.
    classes
        Names of the classes.
    """
    counts = np.zeros((len(classes), len(classes) + 1), np.int64)
    for true, match in zip(true_labels, matches, strict=True):
        counts[true, len(classes) if match.label is None else match.label] += 1
    return Confusion(tuple(classes), counts)
