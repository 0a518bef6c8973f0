"""The report of a run on a belt that never stops."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from beltsort.sorting.moving.entries import Fate
from beltsort.sorting.moving.state import MovingState


@dataclass(frozen=True)
class MovingReport:
    """What became of the objects of a run.

    Attributes
    ----------
    fates
        Number of objects by how they left the belt.
    bins
        Number of objects in each of the model's B bins.
    confusion
        Objects in each bin by true class, shape (B, L), where the cell simulates it; else all 0.
    scans
        Number of scans.
    uncounted
        Most objects that may have passed without a number, while the run was down and the belt's controller
        was started anew.
    stopped_by
        Who asked to stop before all objects had left; None if nobody did.
    """

    fates: Mapping[Fate, int]
    bins: Sequence[int]
    confusion: Sequence[Sequence[int]]
    scans: int
    uncounted: int = 0
    stopped_by: str | None = None

    @classmethod
    def of(cls, state: MovingState, stopped_by: str | None = None) -> "MovingReport":
        """Return the report of a run from its state."""
        fates = {fate: state.fates.get(fate, 0) for fate in Fate}
        confusion = tuple(tuple(row) for row in state.confusion)
        return cls(fates, tuple(state.bins), confusion, state.scans, state.uncounted, stopped_by)

    @property
    def objects(self) -> int:
        """Number of objects that have left, empty cups included."""
        return sum(self.fates.values())
