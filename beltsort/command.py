"""What an actuator is told to do."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Command:
    """An actuator command.

    Attributes
    ----------
    id
        Unique for the device; a repeated command keeps its id.
    name
        `move`, `sort` or `advance`.
    target
        Viewpoint, bin or object at the belt end.
    boot_id
        Of the device when it was first sent.
    arriving
        Whether it only brings the camera to where the planner takes it to be: no planner step, and no look.
    """

    id: str
    name: str
    target: int
    boot_id: str
    arriving: bool = False
