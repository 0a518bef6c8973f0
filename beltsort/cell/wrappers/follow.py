"""A simulated camera sees what a belt that is not simulated has brought."""

from beltsort.cell.commands import AdvanceTo
from beltsort.cell.protocols import FollowsBelt
from beltsort.cell.wrappers.layer import Layer, Request, Send


class Follow(Layer):
    """Tells a simulated world where the belt has come to.

    Parameters
    ----------
    world
        What the camera sees.
    """

    def __init__(self, world: FollowsBelt) -> None:
        self._world = world

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on; after an advance, the world follows."""
        stopped = send(request)
        if isinstance(request.act, AdvanceTo):
            self._world.follow(request.act.object, stopped)
        return stopped
