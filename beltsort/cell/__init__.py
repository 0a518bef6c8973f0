"""The robot cell: what it must be able to do (`protocols`, `commands`), and a simulated one (`simulated`)."""

from beltsort.cell.commands import CommandError, EmergencyStopError, Outcome, within
from beltsort.cell.protocols import Actuator, Arm, Belt, Cell, DepthCamera, Device, Health, Scan, Sorter

__all__ = [
    "Actuator",
    "Arm",
    "Belt",
    "Cell",
    "CommandError",
    "DepthCamera",
    "Device",
    "EmergencyStopError",
    "Health",
    "Outcome",
    "Scan",
    "Sorter",
    "within",
]
