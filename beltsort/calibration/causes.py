"""Why beliefs are not calibrated: looks that depend on each other, and tables that are not known well."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from beltsort import SortingModel
from beltsort.calibration.dependence import Dependence, dependences
from beltsort.calibration.imagined_runs import imagine
from beltsort.calibration.portraits import collect_portraits
from beltsort.calibration.reliability import Reliability, reliability
from beltsort.calibration.sorted_runs import decision_pairs
from beltsort.perception import NearestNeighbour
from beltsort.util.processes import Progress
from beltsort.util.text import numbers_or_none

AS_MODELLED, UNCERTAIN = "labels as modelled", "tables as uncertain as they are"


@dataclass(frozen=True, eq=False)
class Causes:
    """What was measured.

    Attributes
    ----------
    objects
        Number of portraits, and of objects imagined each time.
    dependences
        Of looks at one object.
    imagined
        Reliability of decisions about imagined objects, by arm: `AS_MODELLED` and, for models that have their
        counts, `UNCERTAIN`.
    """

    objects: int
    dependences: list[Dependence]
    imagined: Mapping[str, Mapping[str, Reliability]]

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, fit for JSON."""
        return {
            "objects": self.objects,
            "dependences": [numbers_or_none(asdict(found)) for found in self.dependences],
            "imagined": {
                name: {what: curve.to_dict() for what, curve in curves.items()}
                for name, curves in self.imagined.items()
            },
        }


def find_causes(
    models: Mapping[str, SortingModel],
    database: NearestNeighbour,
    *,
    objects: int,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Causes:
    """Measure on the default simulated cell what the models leave out.

    Parameters
    ----------
    models
        The arms.
    database
        The classifier.
    objects
        Portraits, and imagined objects.
    seed, workers
        As in `beltsort.calibration.sorted_runs.sort_many`.
    progress
        Called with the number of portraits done and in all.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    """
    portraits = collect_portraits(database, objects=objects, seed=seed, workers=workers, progress=progress)
    imagined = {
        name: {
            what: reliability(
                decision_pairs(
                    imagine(model, objects=objects, seed=seed, uncertain=what == UNCERTAIN, workers=workers)
                )
            )
            for what in (AS_MODELLED, UNCERTAIN)
            if what == AS_MODELLED or (model.counts is not None and model.smoothing is not None)
        }
        for name, model in models.items()
    }
    return Causes(objects, dependences(portraits, seed), imagined)
