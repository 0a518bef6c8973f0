"""The robot cell: what it must be able to do (`protocols`), and a simulated one (`simulated`)."""

from beltsort.cell.protocols import Arm, Belt, Cell, DepthCamera, Scan, Sorter

__all__ = ["Arm", "Belt", "Cell", "DepthCamera", "Scan", "Sorter"]
