"""How far sorting from depth scans falls short of what the observation tables promise."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from beltsort import SortingModel
from beltsort.calibration.check import Arm
from beltsort.calibration.simulated_runs import simulate_runs
from beltsort.calibration.sorted_runs import RUN_LENGTH
from beltsort.planning.difference import Difference
from beltsort.util.processes import Progress
from beltsort.util.text import numbers_or_none

OBJECTS = 300  # whose labels are drawn from each model's tables
Z_95 = 1.96


@dataclass(frozen=True)
class Promise:
    """Right decisions of ten, promised and from depth scans.

    Attributes
    ----------
    promised
        With labels drawn from the model's own tables, and its standard error. The mean belief in decisions
        stands for the share of right ones: they have the same mean where the model is the truth, and beliefs
        vary less.
    sorted
        From depth scans, and its standard error.
    """

    promised: Difference
    sorted: Difference

    @property
    def difference(self) -> Difference:
        """From depth scans minus promised; the objects are not the same."""
        error = math.hypot(self.promised.standard_error, self.sorted.standard_error)
        return Difference(self.sorted.mean - self.promised.mean, error)

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % confidence interval of the difference."""
        half = Z_95 * self.difference.standard_error
        return self.difference.mean - half, self.difference.mean + half

    def to_dict(self) -> dict[str, float | None]:
        """Return everything as plain data for JSON; None where a single run tells no error."""
        lower, upper = self.interval
        numbers = {
            "promised": self.promised.mean,
            "promised_error": self.promised.standard_error,
            "right": self.sorted.mean,
            "right_error": self.sorted.standard_error,
            "difference": self.difference.mean,
            "lower": lower,
            "upper": upper,
        }
        return numbers_or_none(numbers)


def promises(
    models: Mapping[str, SortingModel],
    arms: Mapping[str, Arm],
    *,
    objects: int = OBJECTS,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> dict[str, Promise]:
    """Compare what each model promises with what sorting from depth scans has brought.

    Parameters
    ----------
    models
        The models by name.
    arms
        What sorting from depth scans has brought, by the same names.
    objects
        Objects with labels from each model's tables.
    seed, workers
        As in `beltsort.calibration.sorted_runs.sort_many`.
    progress
        Called with the number of runs done and in all, for each model.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    """
    found = {}
    for name, model in models.items():
        runs = simulate_runs(model, objects=objects, seed=seed, workers=workers, progress=progress)
        drawn = Arm.of(runs).means()["confidence"]
        found[name] = Promise(_of_ten(drawn), _of_ten(arms[name].means()["right"]))
    return found


def _of_ten(per_object: Difference) -> Difference:
    return Difference(RUN_LENGTH * per_object.mean, RUN_LENGTH * per_object.standard_error)
