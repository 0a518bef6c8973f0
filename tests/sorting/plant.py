"""A plant: six classes, three bins and sorting by hand; labels with a level of confidence."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import beltsort
from beltsort.cell import Scan
from beltsort.cell.commands import TIMEOUT
from tests.sorting.scripted_cell import Glimpsed, ScriptedCell

CLASSES = ("halogen", "spot", "led bulb", "led tube", "energy saver", "neon tube")
BINS = ("glass", "electronics", "mercury", "by hand")
BIN_OF = (0, 0, 1, 1, 2, 2)
LABELS = tuple(f"{name}, {level}" for name in CLASSES for level in ("unsure", "sure"))
SEED = 5


def plant(viewpoints: Sequence[str] = ("side", "top")) -> beltsort.SortingModel:
    """Return the model: a wrong bin costs 5, mercury elsewhere 50, and a person 3; spots look in two ways."""
    reward = np.where(np.arange(3)[:, np.newaxis] == BIN_OF, 10.0, -5.0)
    reward[:2, 4:] = -50.0
    table = np.full((7, 12), 0.04)
    for kind, looks_like in enumerate((0, 1, 0, 2, 3, 4, 5)):  # the second kind of spot looks like a halogen
        table[kind, 2 * looks_like : 2 * looks_like + 2] += (0.22, 0.3)
    return beltsort.SortingModel(
        CLASSES,
        viewpoints,
        np.tile(table, (2, len(viewpoints), 1, 1)),
        labels=LABELS,
        bins=BINS,
        reward=[*reward.tolist(), [-3.0] * 6],
        modes=[[1.0], [0.6, 0.4], *[[1.0]] * 4],
    )


@dataclass
class PlantCell(ScriptedCell):
    """Draws the label of each look by (object, object at the belt end, viewpoint)."""

    @property
    def bin_names(self) -> Sequence[str]:
        return BINS

    def true_class(self, index: int) -> int:
        return int(np.random.default_rng((SEED, index)).integers(6))

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        self.stamps.append(not_before)
        labels = []
        for place in range(2):
            number = self.first + place
            kind = self.true_class(number) + (self.true_class(number) > 1)
            rng = np.random.default_rng((SEED, number, self.first, self.viewpoint))
            labels.append(rng.choice(12, p=self.model.p_obs[place, self.viewpoint, kind]))
        return Scan(np.array([[label, 0.0, 0.0] for label in labels]), np.eye(4), stamp=not_before)


class Levels:
    """A perception that names its labels, in another order than the model's."""

    labels = tuple(reversed(LABELS))

    def __call__(self, scan: Scan) -> list[Glimpsed]:
        return [Glimpsed(label=11 - int(label), empty=False) for label in scan.points[:, 0]]
