"""The design of the experiments: what is varied, sizes, seeds."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from beltsort import ArgumentError
from beltsort.paper.printed import R_MIN


class Stream(IntEnum):
    """Random streams of the one seed, independent of each other."""

    LABELS = 0
    TUNING = 1
    SCANS = 2
    OPTIMUM = 3
    RUN = 4
    TRUE_CLASSES = 5
    MOVING = 6


@dataclass(frozen=True)
class Design:
    """What is varied, and the number of batches per point; no settings leave a study beyond the paper out.

    Attributes
    ----------
    r_min
        Penalties of a wrong decision at which labels are drawn from tables.
    r_min_compared
        The one at which claims are tested, which must be among all of these.
    r_min_scans
        The same for depth scans.
    r_min_discounts
        The same for the discounts other than the first.
    r_min_optimum
        The same for the offline solution.
    discounts
        The first is used in every figure; the paper does not print one.
    batches, batches_cell, batches_discounts, batches_beyond
        Batches of ten with labels drawn from the paper's tables at the first discount, from the simulated
        cell's tables, at the other discounts, and in the studies beyond the paper.
    batches_tuning, batches_optimum
        Batches of ten whose objects each candidate of a simple policy is tuned on, and batches on which
        regret is measured.
    batches_scans
        Batches of ten sorted from depth scans.
    trials
        Of either planner, per plan.
    seconds_optimum
        Of one offline solution.
    bonuses
        Rewards per nat of information.
    positions
        Numbers of belt positions seen at once, beyond the paper.
    sharpness
        Exponents of the tables that a planner wrongly believes in; 1 is right.
    arrivals
        Shares of the arrival prior that are on the two classes of the objects only.
    speeds
        Of belts that never stop, places per minute.
    runs_moving
        Runs at each of these speeds.
    """

    r_min: tuple[float, ...] = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 350.0, 500.0)
    r_min_compared: float = R_MIN
    r_min_scans: tuple[float, ...] = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 350.0, 500.0)
    r_min_discounts: tuple[float, ...] = (5.0, 50.0, 500.0)
    r_min_optimum: tuple[float, ...] = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 350.0, 500.0)
    discounts: tuple[float, ...] = (0.95, 0.9, 0.99)
    batches: int = 2500
    batches_cell: int = 1000
    batches_discounts: int = 300
    batches_beyond: int = 500
    batches_tuning: int = 3000
    batches_optimum: int = 200
    batches_scans: int = 30
    trials: int = 50
    seconds_optimum: float = 10.0
    bonuses: tuple[float, ...] = (0.0, 1.0, 3.0, 10.0, 30.0)
    positions: tuple[int, ...] = (1, 2, 3, 4)
    sharpness: tuple[float, ...] = (0.5, 0.75, 1.0, 1.5, 2.0)
    arrivals: tuple[float, ...] = (0.0, 0.5, 0.9, 1.0)
    speeds: tuple[float, ...] = (10.0, 15.0, 20.0, 30.0, 60.0)
    runs_moving: int = 200

    def __post_init__(self) -> None:
        """Check that the penalty of the main claim is included."""
        for name in ("r_min", "r_min_scans", "r_min_discounts", "r_min_optimum"):
            if self.r_min_compared not in getattr(self, name):
                raise ArgumentError(
                    f"{name} is {getattr(self, name)}; it must contain {self.r_min_compared:g}"
                )


FULL = Design()
"""All experiments: about three quarters of an hour on two idle cores."""

QUICK = Design(
    r_min_scans=(5.0, 50.0, 500.0),
    r_min_optimum=(5.0, 50.0, 500.0),
    discounts=(0.95, 0.9),
    batches=80,
    batches_cell=30,
    batches_discounts=30,
    batches_beyond=40,
    batches_tuning=500,
    batches_optimum=50,
    batches_scans=2,
    seconds_optimum=3.0,
    bonuses=(0.0, 3.0, 30.0),
    positions=(1, 2, 3),
    sharpness=(0.5, 1.0, 2.0),
    arrivals=(0.0, 1.0),
    speeds=(10.0, 20.0, 60.0),
    runs_moving=20,
)
"""Every figure with few batches: to test that everything runs, not for results."""


def seed_of(seed: int, stream: Stream, *number: int) -> int:
    """Return the seed of one stream, or of one numbered part of it.

    The paths are spawn keys of `numpy.random.SeedSequence`: no two streams share draws, and a part keeps its
    own however many others there are.

    Raises
    ------
    ArgumentError
        If the seed is negative.

    Examples
    --------
    >>> seed_of(0, Stream.LABELS) == seed_of(0, Stream.TUNING)
    False
    """
    if seed < 0:
        raise ArgumentError(f"seed is {seed}; give a whole number from 0 on")
    sequence = np.random.SeedSequence(seed, spawn_key=(int(stream), *number))
    return int(sequence.generate_state(1, np.uint32)[0])
