"""Belts with known motion, and what exact or slightly wrong scans of them would show."""

from collections.abc import Sequence

import numpy as np

from beltsort.perception import Finding
from beltsort.tracking import BeltMotion, EncoderReading, Sighting

SEEN = (-0.05, 0.3)  # metres along the belt that the scans show


def motion_at(speed: float, *, end: float = 10.0, step: float = 0.1) -> BeltMotion:
    """Return the motion of a belt of constant speed, with readings from 0 to `end` seconds."""
    motion = BeltMotion()
    for stamp in np.arange(0.0, end + step / 2.0, step).tolist():
        motion.add(EncoderReading(stamp, speed * stamp))
    return motion


def seen(
    positions: Sequence[float], travel: float, errors: Sequence[float] = ()
) -> list[tuple[int, Sighting]]:
    """Return number and sighting of each object that a scan shows, given where they stand on the belt."""
    wrong = errors or [0.0] * len(positions)
    places = [position - travel + error for position, error in zip(positions, wrong, strict=True)]
    return [(n, Sighting(place)) for n, place in enumerate(places) if SEEN[0] <= place <= SEEN[1]]


def empty(place: float) -> Sighting:
    return Sighting(place, Finding.EMPTY)
