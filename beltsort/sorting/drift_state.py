"""The state of a run's drift detection, as a function of its journal."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from beltsort._core import Belief, SortingModel

if TYPE_CHECKING:
    from beltsort.tables import Alarm, DriftWatch


@dataclass
class DriftState:
    """The drift test, and which of its alarms are in the journal.

    Attributes
    ----------
    watch
        The test, updated with every scan; None if drift detection is off.
    reported
        Number of alarms that are in the journal.
    """

    watch: "DriftWatch | None" = None
    reported: int = 0

    @property
    def alarms(self) -> "tuple[Alarm, ...]":
        """All alarms so far."""
        return () if self.watch is None else tuple(self.watch.alarms)

    @property
    def unreported(self) -> "tuple[Alarm, ...]":
        """Alarms that are not in the journal yet."""
        return self.alarms[self.reported :]

    def begin(self, model: SortingModel, settings: dict[str, Any] | None) -> None:
        """Start drift detection, unless it runs with these settings already; stop it if there are none.

        Parameters
        ----------
        model
            The model whose tables are tested.
        settings
            A `beltsort.sorting.rules.Drift` as plain data; None to stop.
        """
        if settings is None:
            self.watch, self.reported = None, 0
        elif self.watch is None or self.watch.false_alarm != settings["false_alarm"]:
            from beltsort.tables import DriftWatch

            self.watch, self.reported = DriftWatch(model, false_alarm=settings["false_alarm"]), 0

    def see(self, belief_before: Belief, viewpoint: int, labels: Sequence[int | None]) -> None:
        """Update the test with one scan."""
        if self.watch is not None:
            self.watch.observe(belief_before, viewpoint, labels)

    def snapshot(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {"watch": None if self.watch is None else self.watch.state(), "told": self.reported}

    @classmethod
    def of_snapshot(cls, model: SortingModel, data: dict[str, Any]) -> "DriftState":
        """Return what `snapshot` returned as plain data."""
        if data["watch"] is None:
            return cls()
        from beltsort.tables import DriftWatch

        return cls(DriftWatch.of_state(model, data["watch"]), data["told"])
