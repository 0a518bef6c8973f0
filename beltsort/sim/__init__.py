"""A simulated cell: belt, cups, bulbs, structured-light camera.

Observation tables estimated here describe the simulator's settings, not a real cell. Axial, lateral and
disparity noise follow published measurements; the model of glass surfaces and the poses of objects in their
cups (`SensorNoise`, `PoseMix`) are plausible choices, with which the classifier often errs but is far better
than chance.
"""

from typing import TYPE_CHECKING, Any

from beltsort.geometry import SphereViewpoint
from beltsort.sim.belt_drive import BeltDrive
from beltsort.sim.config import ArmErrors, CellConfig, Cup, PoseMix
from beltsort.sim.sensor import Camera, SensorNoise

if TYPE_CHECKING:
    from beltsort.sim.cell import SimulatedCell
    from beltsort.sim.moving_cell import MovingCell

__all__ = [
    "ArmErrors",
    "BeltDrive",
    "Camera",
    "CellConfig",
    "Cup",
    "MovingCell",
    "PoseMix",
    "SensorNoise",
    "SimulatedCell",
    "SphereViewpoint",
]


def __getattr__(name: str) -> Any:
    """Import `SimulatedCell` and `MovingCell`, and with them Open3D, on first use."""
    if name == "MovingCell":
        from beltsort.sim.moving_cell import MovingCell

        return MovingCell
    if name == "SimulatedCell":
        from beltsort.sim.cell import SimulatedCell

        return SimulatedCell
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
