"""A link to a ROS 1 node."""

import os
import sys
from typing import Any

from beltsort.cell.commands import CommandError
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.link import Link, Topics
from beltsort.drivers.ros.process import NodeProcess, Program
from beltsort.drivers.ros1.master import Master, node_pid
from beltsort.drivers.ros1.options import Ros1Options

MASTER_TIMEOUT = 2.0
"""Timeout of the master's replies, seconds."""

HEALTH_TIMEOUT = 1.0
"""Timeout of the master's and the node's replies about a peer, seconds each."""

PACKAGES = "on Debian, run scripts/bootstrap, or sudo apt-get install python3-rospy python3-tf2-msgs"


class Ros1Link(Link):
    """A ROS 1 node, also restarted after the master was restarted.

    Parameters
    ----------
    options
        Address of the ROS 1 system.
    role
        Part of the node's name.
    topics
        Its topics.
    """

    def __init__(self, options: Ros1Options, role: str, topics: Topics) -> None:
        super().__init__(role, topics)
        self._master, self._options = Master(options.master), options

    @property
    def address(self) -> str:
        """The master's URI."""
        return self._master.uri

    def identity(self, timeout: float) -> str:
        """Return the identity of the master."""
        return self._master.identity(timeout)

    def peer(self, _topic: str, node: str, /) -> tuple[str, str]:
        """Return the identities of the master and of a node, which is asked for it."""
        boot_id = self.identity(HEALTH_TIMEOUT)
        uri = self._master.node_uri(node, HEALTH_TIMEOUT)
        if uri is None:
            return boot_id, f"the node {node} has left the master; start it again"
        boot_id += f" {uri}"
        try:
            return f"{boot_id} {node_pid(node, uri, HEALTH_TIMEOUT)}", ""
        except CommandError as reason:
            return boot_id, str(reason)

    def _usable(self, process: NodeProcess, timeout: float) -> bool:
        uri = self._master.node_uri(f"/{process.name}", min(MASTER_TIMEOUT, timeout))
        return uri is not None and uri == process.started["uri"]

    def _start(self, setup: dict[str, Any], deadline: Deadline) -> NodeProcess:
        self.identity(min(MASTER_TIMEOUT, deadline.left()))  # rospy waits for a master without a timeout
        return NodeProcess(_program(self._options), setup, deadline.left())


def _program(options: Ros1Options) -> Program:
    """Return the node program, with this process's `sys.path` and the addresses of ROS."""
    path = os.pathsep.join(entry or os.curdir for entry in sys.path)
    ros = {"ROS_MASTER_URI": options.master, "ROS_IP": options.address, "ROS_HOSTNAME": options.address}
    return Program(
        [sys.executable, "-m", "beltsort.drivers.ros1.node"],
        {**os.environ, "PYTHONPATH": path, **ros},
        "ROS 1 needs rospy",
        PACKAGES,
    )
