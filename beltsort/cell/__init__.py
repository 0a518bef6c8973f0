"""The robot cell: protocols of its devices (`protocols`, `commands`), and wrappers of them."""

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
from beltsort.cell.diverting import BeltReading, Diversion, DiversionStatus, DivertingBelt, DivertingCell
from beltsort.cell.protocols import Actuator, Arm, Belt, Cell, DepthCamera, Device, Health, Scan, Sorter

__all__ = [
    "Act",
    "Actuator",
    "AdvanceTo",
    "Arm",
    "Belt",
    "BeltReading",
    "Cell",
    "CommandError",
    "DepthCamera",
    "Device",
    "Diversion",
    "DiversionStatus",
    "DivertingBelt",
    "DivertingCell",
    "EmergencyStopError",
    "Health",
    "MoveTo",
    "Outcome",
    "Scan",
    "SortInto",
    "Sorter",
    "within",
]
