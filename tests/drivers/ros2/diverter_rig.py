"""The reference controller on ROS 2 of a belt that never stops, in a process and a domain of its own."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from beltsort.drivers.ros2 import Ros2Diverter, Ros2DiverterOptions
from tests.drivers.ros2.rig import ROOT, HeldDomain, require_ros2
from tests.drivers.ros2.scene import PYTHON
from tests.panel import PanelProcess

ANSWER_TIMEOUT = 4.0
"""Seconds; tests that wait for an answer in vain give the call itself less time."""


class DiverterRig:
    """Starts, stops and kills the controller.

    Attributes
    ----------
    ended
        File with a line for each diversion that has ended.
    """

    def __init__(self, folder: Path) -> None:
        require_ros2("rclpy", "std_msgs")
        self._held = HeldDomain()
        self.ended = folder / "ended.jsonl"
        self._environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(self._held.number),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(folder),
            "PYTHONPATH": str(ROOT),
        }
        self.start()

    def start(self, *arguments: str) -> None:
        """Start the controller, anew after `kill`."""
        module = ["-m", "beltsort.testing.ros2_controller"]
        command = [PYTHON, *module, "--ended", str(self.ended), *arguments]
        self.controller = PanelProcess(command, self._environment, [self._held.lock])

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

    def close(self) -> None:
        """End the controller."""
        self.controller.kill()
        self._held.close()
