"""A simulated cell: belt, cups, bulbs, structured-light camera.

A table collected here says what the simulator was set to, not how a real cell behaves. Axial, lateral and
disparity noise are published measurements; how glass returns the pattern and how objects lie in their cups
are plausible choices (`SensorNoise`, `PoseMix`), made so that classes are confused neither rarely nor
hopelessly.
"""

from typing import TYPE_CHECKING, Any

from beltsort.geometry import SphereViewpoint
from beltsort.sim.config import ArmErrors, CellConfig, Cup, PoseMix
from beltsort.sim.sensor import Camera, SensorNoise

if TYPE_CHECKING:
    from beltsort.sim.cell import SimulatedCell

__all__ = [
    "ArmErrors",
    "Camera",
    "CellConfig",
    "Cup",
    "PoseMix",
    "SensorNoise",
    "SimulatedCell",
    "SphereViewpoint",
]


def __getattr__(name: str) -> Any:
    """Load the cell, and with it Open3D, on first use."""
    if name == "SimulatedCell":
        from beltsort.sim.cell import SimulatedCell

        return SimulatedCell
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
