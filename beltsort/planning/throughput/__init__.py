"""How many objects a minute a cell sorts on a belt that never stops: policies at several belt speeds."""

from beltsort.planning.throughput.arm import ArmTimes
from beltsort.planning.throughput.study import (
    OBJECTS,
    PURITY,
    RUNS,
    Held,
    SpeedResult,
    Throughput,
    throughput,
)

__all__ = ["OBJECTS", "PURITY", "RUNS", "ArmTimes", "Held", "SpeedResult", "Throughput", "throughput"]
