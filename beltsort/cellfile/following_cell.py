"""Simulated arm and camera over a real belt that never stops, in real time: to try a controller."""

import time

from beltsort.cell.diverting import BeltReading
from beltsort.sim.moving_cell import MovingCell

KEPT = 100
"""Number of readings of the belt that are kept."""


class FollowingCell(MovingCell):
    """A simulated cell whose belt is where another one's encoder says, on the monotonic clock.

    Setting `clock` waits until that time. After a restart of the belt's controller the objects stay where
    they are, and their coordinates begin anew.

    Parameters are those of `MovingCell`.
    """

    _boot_id: str | None = None
    _offset = 0.0  # of the simulated travel from that of the belt's encoder

    @property
    def clock(self) -> float:
        """The time, seconds on the monotonic clock."""
        return time.monotonic()

    @clock.setter
    def clock(self, then: float) -> None:
        time.sleep(max(0.0, then - time.monotonic()))

    def follow_belt(self, reading: BeltReading) -> None:
        """Bring the simulated belt to where the other one is."""
        if reading.boot_id != self._boot_id:
            began = 0.0 if self._boot_id is None else self.travel(reading.stamp) - reading.travel
            self._boot_id, self._offset = reading.boot_id, began
        speed = self.moving.belt_speed if reading.moving else 0.0
        self._speeds = [*self._speeds[1 - KEPT :], (reading.stamp, reading.travel + self._offset, speed)]

    def stop(self) -> None:
        """Do nothing: the belt is another device's."""

    def true_class_at(self, coordinate: float) -> int | None:
        """Return the class index of the object at a coordinate; None for an empty cup."""
        return self.true_class(max(0, round((coordinate + self._offset) / self.layout.spacing)))
