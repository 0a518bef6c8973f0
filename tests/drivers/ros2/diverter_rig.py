"""The reference controller on ROS 2 of a belt that never stops, in a process and a domain of its own."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from beltsort.drivers.ros2 import Ros2Diverter, Ros2DiverterOptions
from tests.drivers.ros2.relay import MACHINE
from tests.drivers.ros2.rig import ROOT, HeldDomain, require_ros2
from tests.drivers.ros2.scene import PYTHON
from tests.panel import PanelProcess

RELAY = Path(__file__).with_name("relay.py")
BEHIND_RELAY = ("--request-topic", MACHINE.request_topic, "--reply-topic", MACHINE.reply_topic)
"""Arguments of a controller that clients reach through a relay."""

ANSWER_TIMEOUT = 20.0
"""Seconds, in which nodes find each other; tests that wait for one in vain give the call itself less time."""


class DiverterRig:
    """Starts, stops and kills the controller.

    Attributes
    ----------
    ended
        File with a line for each diversion that has ended.
    """

    def __init__(self, folder: Path, *arguments: str) -> None:
        require_ros2("rclpy", "std_msgs")
        self._held = HeldDomain()
        self.ended = folder / "ended"
        module = ["-m", "beltsort.testing.ros2_controller"]
        self._command = [PYTHON, *module, "--ended", str(self.ended), *arguments]
        self._environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(self._held.number),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(folder),
            "PYTHONPATH": str(ROOT),
        }
        self.start()

    def start(self) -> None:
        """Start the controller, anew after it was killed."""
        self.controller = self.process(*self._command)

    def process(self, *command: str) -> PanelProcess:
        """Start another program in this domain."""
        return PanelProcess(command, self._environment, [self._held.lock])

    @property
    def boot_id(self) -> str:
        """That of the controller that runs."""
        return str(self.controller.announced["boot_id"])

    def options(self, **changes: Any) -> Ros2DiverterOptions:
        """Return the options of a device of this controller, with changes."""
        usual = Ros2DiverterOptions(python=PYTHON, domain_id=self._held.number, answer_timeout=ANSWER_TIMEOUT)
        return replace(usual, **changes)

    def device(self, **changes: Any) -> Ros2Diverter:
        """Return a device of this controller."""
        return Ros2Diverter(self.options(**changes))

    def relay(self) -> PanelProcess:
        """Start a relay to a controller on the topics of `MACHINE`."""
        return self.process(PYTHON, str(RELAY))

    def close(self) -> None:
        """End the controller."""
        self.controller.kill()
        self._held.close()
