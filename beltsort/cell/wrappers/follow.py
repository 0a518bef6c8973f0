"""The position of a real belt, for a simulated camera."""

from beltsort.cell.commands import AdvanceTo
from beltsort.cell.protocols import FollowsBelt
from beltsort.cell.wrappers.layer import Layer, Request, Send


class Follow(Layer):
    """Reports the belt's advances to a simulated world.

    Parameters
    ----------
    world
        The world that the camera sees.
    """

    def __init__(self, world: FollowsBelt) -> None:
        self._world = world

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on; report an advance to the world."""
        stopped = send(request)
        if isinstance(request.act, AdvanceTo):
            self._world.follow(request.act.object, stopped)
        return stopped
