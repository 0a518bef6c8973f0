"""Models compared on the same objects: how well beliefs are calibrated, and what sorting costs."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsort.calibration.reliability import Reliability, reliability
from beltsort.calibration.sorted_runs import RUN_LENGTH, SortedRun, decision_pairs, step_pairs
from beltsort.planning.difference import Difference
from beltsort.util.text import numbers_or_none

Array = NDArray[np.float64]

KINDS = {"decisions": decision_pairs, "steps": step_pairs}


@dataclass(frozen=True, eq=False)
class Arm:
    """The results of sorting with one model.

    Attributes
    ----------
    right, steps
        Right decisions, and planner steps, per object: one value for each run, shape (runs,).
    confidence
        Mean probability that the decided bin is right, by run, shape (runs,).
    confusion
        Number of objects by bin and true class, shape (B, L).
    curves
        Reliability of the beliefs in decisions (`decisions`), and in all classes after each scan (`steps`).
    """

    right: Array
    steps: Array
    confidence: Array
    confusion: NDArray[np.int64]
    curves: Mapping[str, Reliability]

    @classmethod
    def of(cls, runs: Sequence[SortedRun]) -> "Arm":
        """Evaluate runs, of which there is at least one."""
        return cls(
            np.array([run.correct / RUN_LENGTH for run in runs]),
            np.array([run.steps / RUN_LENGTH for run in runs]),
            np.array([np.mean([belief for *_, belief in run.decisions]) for run in runs]),
            np.sum([run.confusion for run in runs], axis=0),
            {kind: reliability(pairs(runs)) for kind, pairs in KINDS.items()},
        )

    def means(self) -> dict[str, Difference]:
        """Return mean and standard error over runs of what is counted per object."""
        return {name: _mean(values) for name, values in self._per_run().items()}

    def minus(self, other: "Arm") -> dict[str, Difference]:
        """Return by how much this arm exceeds one that sorted the same objects, with paired errors."""
        paired = other._per_run()
        differences = {name: _mean(values - paired[name]) for name, values in self._per_run().items()}
        for kind, curve in self.curves.items():
            others = other.curves[kind]
            error = float((curve.resampled_ece - others.resampled_ece).std())
            differences[f"ECE of {kind}"] = Difference(curve.ece - others.ece, error)
        return differences

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, fit for JSON."""
        means = {name: numbers_or_none(asdict(mean)) for name, mean in self.means().items()}
        curves = {kind: curve.to_dict() for kind, curve in self.curves.items()}
        return {**means, "confusion": self.confusion.tolist(), **curves}

    def _per_run(self) -> dict[str, Array]:
        return {"right": self.right, "confidence": self.confidence, "steps": self.steps}


def _mean(values: Array) -> Difference:
    """Return mean and standard error over runs; one run tells no error."""
    runs = len(values)
    error = float(values.std(ddof=1)) / float(np.sqrt(runs)) if runs > 1 else float("nan")
    return Difference(float(values.mean()), error)
