"""The table [moving] of a cell file: a belt that never stops."""

from pathlib import Path
from typing import Annotated, Any

from beltsort import ArgumentError, MovingBelt, MovingPlanner, SortingModel
from beltsort.cellfile.sections import Planner, Seconds
from beltsort.cellfile.validation import Section
from beltsort.planning.named_moving_policy import DEFAULT_TRIALS, named_moving_policy
from beltsort.planning.policy import MovingPolicy
from beltsort.planning.throughput import ArmTimes
from beltsort.util.extras import extra

with extra("cell"):
    from pydantic import Field, FiniteFloat, NonNegativeInt, PositiveInt

Price = Annotated[FiniteFloat, Field(ge=0.0)]

USED_RULES = ("empty_looks", "scan_attempts", "retry_delays")
"""The rules of the loop that hold on a belt that never stops."""


class Moving(Section):
    """A belt that never stops: its times in ticks, as in `beltsort.MovingBelt`."""

    ticks_per_place: PositiveInt
    """Ticks in which the belt carries an object one place, `spacing`, further."""
    seconds_per_tick: Seconds
    """How long a tick lasts, seconds."""
    reach: PositiveInt = 1
    """Places, from the exit, at which objects can be decided."""
    move_ticks: NonNegativeInt | tuple[tuple[NonNegativeInt, ...], ...] = 1
    """Ticks of a move of the camera: one number, or a row for each viewpoint from which it starts."""
    scan_ticks: NonNegativeInt = 0
    """Ticks of a scan."""
    missed: dict[str, Price] = Field(default_factory=dict)
    """Price of an object that passes the exit undecided, by class; the largest reward if missing."""
    exposure: Annotated[FiniteFloat, Field(ge=0.0, le=10.0)] = 0.0
    """Time in which the camera reads its rows from top to bottom, seconds; 0 if all at once."""

    def belt(self, model: SortingModel) -> MovingBelt:
        """Return the belt that is planned for.

        Raises
        ------
        ArgumentError, ModelError
            As `beltsort.MovingBelt`.
        """
        ticks = self.move_ticks
        return MovingBelt(
            model,
            ticks_per_place=self.ticks_per_place,
            reach=self.reach,
            move_ticks=ticks if isinstance(ticks, int) else [list(row) for row in ticks],
            scan_ticks=self.scan_ticks,
            missed=[self.missed[name] for name in model.classes] if self.missed else None,
            seconds_per_tick=self.seconds_per_tick,
        )

    @property
    def times(self) -> ArmTimes:
        """The durations in seconds."""
        ticks, tick = self.move_ticks, self.seconds_per_tick
        move = (
            ticks * tick if isinstance(ticks, int) else tuple(tuple(n * tick for n in row) for row in ticks)
        )
        return ArmTimes(move, self.scan_ticks * tick, 0.0, tick)

    def speed(self, spacing: float) -> float:
        """Return the speed of the belt, metres per second."""
        return spacing / (self.ticks_per_place * self.seconds_per_tick)


def moving_policy(planner: Planner, belt: MovingBelt, folder: Path) -> MovingPolicy:
    """Return the policy of a belt that never stops.

    Parameters
    ----------
    planner
        Its name, or the budget of the planner.
    belt
        The belt.
    folder
        Where modules of your own are found.

    Raises
    ------
    ArgumentError
        As `named_moving_policy`, or if the policy is for a belt that stands while the arm looks.
    """
    if planner.policy != "despot":
        planned, policy = named_moving_policy(planner.policy, belt, folder)
        if planned != belt:
            raise ArgumentError(
                f"{planner.policy!r} is for a belt that stands while the arm looks, expected one for a belt "
                "that never stops: choose another, or leave [moving] out"
            )
        return policy
    settings: dict[str, Any] = {"seed": planner.seed}
    if "scenarios" in planner.model_fields_set:
        settings["scenarios"] = planner.scenarios
    if planner.seconds is not None:
        return MovingPlanner(belt, seconds=planner.seconds, **settings)
    return MovingPlanner(belt, trials=planner.trials or DEFAULT_TRIALS, **settings)
