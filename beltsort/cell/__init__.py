"""The robot cell: what it must be able to do (`protocols`, `commands`), and what can be put around it."""

from beltsort.cell.commands import (
    Act,
    AdvanceTo,
    CommandError,
    EmergencyStopError,
    MoveTo,
    Outcome,
    SortInto,
    within,
)
from beltsort.cell.protocols import Actuator, Arm, Belt, Cell, DepthCamera, Device, Health, Scan, Sorter

__all__ = [
    "Act",
    "Actuator",
    "AdvanceTo",
    "Arm",
    "Belt",
    "Cell",
    "CommandError",
    "DepthCamera",
    "Device",
    "EmergencyStopError",
    "Health",
    "MoveTo",
    "Outcome",
    "Scan",
    "SortInto",
    "Sorter",
    "within",
]
