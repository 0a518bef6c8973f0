"""The interface by which an arm is commanded."""

from typing import Protocol

from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.joints import Joints
from beltsort.drivers.ros.link import Link, Outgoing, Topics


class Commanding(Protocol):
    """An interface by which an arm is commanded."""

    topic: str
    """The topic or action of the commands."""
    topics: Topics
    """The topics or actions that it uses."""
    repeats: bool
    """Whether commands must be repeated during a motion."""
    pause: float
    """Longest time for which the arm may plan a motion before it begins, seconds."""

    def begin(self, target: Joints) -> Outgoing:
        """Return the message that starts a motion."""

    def again(self) -> Outgoing | None:
        """Return the message to repeat during a motion, if any."""

    def halt(self, joints: Joints) -> Outgoing:
        """Return the message that stops an arm whose joints are at `joints`."""

    def ended(self, link: Link, deadline: Deadline) -> str | None:
        """Return how the arm reports the end of the motion; None while it runs, or if it does not report."""
