"""How many objects a minute a cell sorts on a belt that never stops: policies at several belt speeds."""

from beltsort.planning.throughput.arm import ArmTimes
from beltsort.planning.throughput.study import (
    CELL_OBJECTS,
    CELL_RUNS,
    OBJECTS,
    PURITY,
    RUNS,
    Held,
    SpeedResult,
    Throughput,
    throughput,
)

__all__ = [
    "CELL_OBJECTS",
    "CELL_RUNS",
    "OBJECTS",
    "PURITY",
    "RUNS",
    "ArmTimes",
    "Held",
    "SpeedResult",
    "Throughput",
    "throughput",
]
