"""A link to a ROS 2 node."""

import os
import shutil
import sys
from math import inf
from pathlib import Path
from typing import Any

from beltsort.cell.commands import CommandError, Outcome
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.link import GRACE, Link, Topics
from beltsort.drivers.ros.process import NodeProcess, Program
from beltsort.drivers.ros2.options import Ros2Options

START = Path(__file__).with_name("start.py")

DEVICE = "beltsort.drivers.ros2.node"
"""The node program of devices."""

SILENCE = 2.0
"""Time without a message after which a publisher is considered not to answer, seconds."""

DISCOVERY = 5.0
"""Time in which nodes find each other, seconds; up to 3 on an idle computer."""

SOURCED = 'source "$1" && shift && exec "$@"'
"""Command of bash that sources a file and becomes another program."""

DISTRIBUTION = (
    'give setup = "/opt/ros/jazzy/setup.bash" (the file of your distribution), or python = "..." (an '
    "environment with pip install 'ros-rclpy[fastrtps]' and the messages; docs/ros.md)"
)


class Ros2Link(Link):
    """A ROS 2 node.

    Parameters
    ----------
    options
        The ROS 2 installation.
    role
        Part of the node's name.
    topics
        Its topics.
    """

    discovery = DISCOVERY

    def __init__(self, options: Ros2Options, role: str, topics: Topics) -> None:
        super().__init__(role, topics)
        self._options = options
        self._names: dict[str, str] = {}
        """Names of nodes by the identity of a publisher."""

    @property
    def address(self) -> str:
        """The domain."""
        domain = self._options.domain_id
        return f"ros2 domain {os.environ.get('ROS_DOMAIN_ID', '0') if domain is None else domain}: "

    def identity(self, _timeout: float) -> str:
        """Return nothing: nodes talk to each other without a master."""
        return ""

    def peer(self, topic: str, node: str, /) -> tuple[str, str]:
        """Return the identity of the publisher of the next message on a topic.

        A node that was killed or hangs is known to the middleware for another 20 s, so it is only taken to
        answer if it publishes.
        """
        deadline = Deadline(SILENCE + self.discovery_left())
        last = self.newest(topic, deadline, not_before=inf).values["number"]
        values = self.newest(topic, deadline, after=last, wait=deadline.left(), not_before=inf).values
        if values["message"] is None:
            who = f"the node {self._names[node]}" if node in self._names else "its publisher"
            return node, f"{who} sends nothing on {topic} (for {SILENCE:g} s); check it, and start it again"
        if values["node"] not in self._names:  # asked for now: the name of a node that was killed is lost
            self._names.update(self.ask("publishers", GRACE, topic=topic).values["names"])
        return values["node"], ""

    def _usable(self, _process: NodeProcess, _timeout: float) -> bool:
        return True

    def _start(self, setup: dict[str, Any], deadline: Deadline) -> NodeProcess:
        return NodeProcess(node_program(self._options, DEVICE), setup, deadline.left())


def node_program(options: Ros2Options, module: str) -> Program:
    """Return a node program, the `main` of a module, with an installation of ROS 2.

    Raises
    ------
    CommandError
        `NOT_DONE` if the file to source or the interpreter does not exist.
    """
    python = options.python or ("python3" if options.setup else sys.executable)
    command = [python, str(START), module]
    if options.setup:
        if not Path(options.setup).is_file():
            raise CommandError(
                f"setup is {options.setup!r}, which is no file; {DISTRIBUTION}", Outcome.NOT_DONE
            )
        command = ["bash", "-c", SOURCED, "bash", options.setup, *command]
    elif shutil.which(python) is None:
        raise CommandError(f"python is {python!r}, which is no program; {DISTRIBUTION}", Outcome.NOT_DONE)
    ros = {"ROS_AUTOMATIC_DISCOVERY_RANGE": options.discovery_range}
    if options.domain_id is not None:
        ros["ROS_DOMAIN_ID"] = str(options.domain_id)
    return Program(
        command, {**os.environ, **ros}, f"ROS 2 needs rclpy and messages in {python}", DISTRIBUTION
    )
