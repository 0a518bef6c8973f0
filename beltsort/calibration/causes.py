"""Why beliefs are not calibrated: looks that depend on each other, and statistical errors of the tables."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from beltsort import SortingModel
from beltsort.calibration.dependence import Dependence, collect_looks, dependences
from beltsort.calibration.reliability import Reliability, reliability
from beltsort.calibration.simulated_runs import simulate_runs
from beltsort.calibration.sorted_runs import decision_pairs
from beltsort.perception import Classifier
from beltsort.util.processes import Progress
from beltsort.util.text import numbers_or_none

AS_MODELLED, UNCERTAIN = "labels as modelled", "tables as uncertain as they are"


@dataclass(frozen=True, eq=False)
class Causes:
    """Measured reasons why beliefs are not calibrated.

    Attributes
    ----------
    objects
        Number of objects scanned, and of objects simulated for each arm.
    dependences
        Of looks at one object.
    simulated
        Reliability of decisions if labels are drawn from tables, by arm and kind of tables: `AS_MODELLED`
        and, for models that have their counts, `UNCERTAIN`.
    """

    objects: int
    dependences: list[Dependence]
    simulated: Mapping[str, Mapping[str, Reliability]]

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, fit for JSON."""
        return {
            "objects": self.objects,
            "dependences": [numbers_or_none(asdict(found)) for found in self.dependences],
            "imagined": {
                name: {tables: curve.to_dict() for tables, curve in curves.items()}
                for name, curves in self.simulated.items()
            },
        }


def find_causes(
    models: Mapping[str, SortingModel],
    database: Classifier,
    *,
    objects: int,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Causes:
    """Measure, on the default simulated cell, two effects that the models leave out.

    Parameters
    ----------
    models
        The arms.
    database
        The classifier.
    objects
        Least number of objects to scan, and to simulate for each arm.
    seed, workers
        As in `beltsort.calibration.sorted_runs.sort_many`.
    progress
        Called with the number of passages scanned and in all.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    """
    looks = collect_looks(database, objects=objects, seed=seed, workers=workers, progress=progress)
    objects = len(looks.true)
    simulated = {
        name: {
            what: reliability(
                decision_pairs(
                    simulate_runs(
                        model, objects=objects, seed=seed, uncertain=what == UNCERTAIN, workers=workers
                    )
                )
            )
            for what in (AS_MODELLED, UNCERTAIN)
            if what == AS_MODELLED or (model.counts is not None and model.smoothing is not None)
        }
        for name, model in models.items()
    }
    return Causes(objects, dependences(looks, seed), simulated)
