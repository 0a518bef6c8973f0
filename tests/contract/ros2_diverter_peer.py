"""A belt that never stops on ROS 2, under contract, with a relay between client and controller."""

import os
import signal
from pathlib import Path

from beltsort.drivers.ros2 import Ros2Diverter
from tests.contract.diverting_peers import DIVERTERS, SPEED, DivertingPeer
from tests.drivers.ros2.diverter_rig import BEHIND_RELAY, DiverterRig


class Ros2DiverterPeer(DivertingPeer):
    """The reference controller, whose topics a relay connects with those of the clients."""

    name = "Ros2"

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        distances = ",".join(map(str, DIVERTERS))
        self.rig = DiverterRig(folder, *BEHIND_RELAY, "--diverters", distances, "--belt-speed", str(SPEED))
        self.relay = self.rig.relay()

    def connected(self) -> Ros2Diverter:
        device = self.rig.device()
        device.connect()
        return device

    def push(self, button: str) -> None:
        shown = self.rig.controller.push(button)
        assert "error" not in shown, shown

    def cut(self) -> None:
        """Kill the clients' nodes."""
        for device in self.devices:
            assert isinstance(device, Ros2Diverter)
            process = device._node._process
            if process is not None and process.alive():
                os.kill(process.process_id, signal.SIGKILL)

    def slow(self, seconds: float) -> None:
        self.relay.push(f"slow {seconds}")

    def hang(self) -> None:
        self.rig.controller.hang()

    def resume(self) -> None:
        self.rig.controller.resume()

    def kill(self) -> None:
        self.rig.controller.kill()

    def restart(self) -> None:
        self.rig.start()

    def close(self) -> None:
        for device in self.devices:
            device.close()
        self.relay.kill()
        self.rig.close()
