"""Seconds of arm, camera and belt as ticks."""

import math
from dataclasses import dataclass
from itertools import chain

from beltsort._core import ArgumentError, MovingBelt, SortingModel


@dataclass(frozen=True)
class ArmTimes:
    """How long a cell takes, in seconds.

    Attributes
    ----------
    move
        Seconds of a move of the camera, also from a viewpoint to itself; or those from each of the K
        viewpoints to each, ``move[start][end]``.
    scan
        Seconds of a scan and its labels.
    sort
        Seconds of a decision in which the arm does nothing else; 0 if the sorter works on its own.
    tick
        Seconds of a tick. Durations of the arm are rounded up to whole ticks, so that nothing is promised
        that takes longer; the time of the belt for a place is rounded to the nearest tick.
    """

    move: float | tuple[tuple[float, ...], ...] = 0.5
    scan: float = 0.5
    sort: float = 0.0
    tick: float = 0.5

    def __post_init__(self) -> None:
        """Check the times.

        Raises
        ------
        ArgumentError
            For a time that is negative or not finite, or a tick of 0.
        """
        moves = [self.move] if isinstance(self.move, float | int) else list(chain.from_iterable(self.move))
        given = {"move": moves, "scan": [self.scan], "sort": [self.sort], "tick": [self.tick]}
        for name, seconds in ((name, seconds) for name, times in given.items() for seconds in times):
            if not math.isfinite(seconds) or seconds < 0 or (name == "tick" and seconds == 0):
                raise ArgumentError(
                    f"{name} = {seconds} seconds, expected a finite time that is not negative, and a tick "
                    "above 0: correct it"
                )

    def belt(
        self,
        model: SortingModel,
        places_per_minute: float,
        reach: int | None = None,
        missed: float | None = None,
    ) -> MovingBelt:
        """Return a belt of a speed.

        Parameters
        ----------
        model
            Classes, tables and rewards.
        places_per_minute
            Speed of the belt.
        reach
            Places, from the exit, at which objects can be decided; default: all.
        missed
            Price of an object that passes the exit undecided; default as for `MovingBelt`.

        Raises
        ------
        ArgumentError
            For a speed that is not positive, or at which the belt passes a place in under half a tick.
        """
        if isinstance(self.move, float | int):
            move: int | list[list[int]] = self._ticks(self.move)
        else:
            move = [[self._ticks(seconds) for seconds in row] for row in self.move]
        return MovingBelt(
            model,
            ticks_per_place=self.ticks_per_place(places_per_minute),
            reach=model.positions if reach is None else reach,
            move_ticks=move,
            scan_ticks=self._ticks(self.scan),
            sort_ticks=self._ticks(self.sort),
            missed=None if missed is None else [missed] * len(model.classes),
            seconds_per_tick=self.tick,
        )

    def ticks_per_place(self, places_per_minute: float) -> int:
        """Return the ticks in which a belt of a speed passes a place.

        Raises
        ------
        ArgumentError
            As `belt`.
        """
        if not (math.isfinite(places_per_minute) and places_per_minute > 0):
            raise ArgumentError(
                f"a belt speed is {places_per_minute:g} places per minute, expected one above 0: correct it"
            )
        ticks = round(60 / places_per_minute / self.tick)
        if ticks == 0:
            raise ArgumentError(
                f"at {places_per_minute:g} places per minute the belt passes a place in "
                f"{60 / places_per_minute:.3g} s, expected at least half a tick of {self.tick:g} s: choose a "
                "shorter tick"
            )
        return ticks

    def _ticks(self, seconds: float) -> int:
        return math.ceil(seconds / self.tick - 1e-9)
