"""Readings of a belt that never stops for a simulated camera over it."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from beltsort.cell.diverting import BeltReading
from beltsort.cell.wrappers.layer import Layer


@runtime_checkable
class FollowsTravel(Protocol):
    """A simulated world whose objects are moved by the cell's belt, which never stops."""

    def follow_belt(self, reading: BeltReading) -> None:
        """Place the objects where a reading of the belt's encoder says."""


class FollowTravel(Layer):
    """Tells a simulated camera every reading of the belt's encoder.

    Parameters
    ----------
    camera
        The camera.
    """

    def __init__(self, camera: FollowsTravel) -> None:
        self._camera = camera

    def reading(self, ask: Callable[[float], BeltReading], timeout: float) -> BeltReading:
        """Pass a query on, and its reply to the camera."""
        reading = ask(timeout)
        self._camera.follow_belt(reading)
        return reading
