"""A simulated camera sees what a belt that is not simulated has brought."""

from typing import Any

from beltsort.cell.protocols import FollowsBelt
from beltsort.cell.wrappers.wrapped import Act, Call


class Follow:
    """Tells a simulated world where the belt has come to.

    Parameters
    ----------
    world
        What the camera sees.
    """

    def __init__(self, world: FollowsBelt) -> None:
        self._world = world

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on."""
        result = act(call)
        if call.name == "advance_to":
            self._world.follow(int(call.target or 0), float(result))
        return result
