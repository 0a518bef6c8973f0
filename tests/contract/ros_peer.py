"""Cells on ROS 1, with a master, and on ROS 2: peers in processes of their own."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

from beltsort.drivers.ros1 import Ros1Arm, Ros1Belt, Ros1Camera, Ros1Sorter
from beltsort.drivers.ros2 import (
    Ros2Arm,
    Ros2Belt,
    Ros2Camera,
    Ros2ServiceBelt,
    Ros2ServiceSorter,
    Ros2Sorter,
)
from tests.contract.peer import ProcessPeer, SeeingPeer
from tests.drivers.ros.rig import await_ready
from tests.drivers.ros.scenery import TAUGHT
from tests.drivers.ros1 import rig as rig1
from tests.drivers.ros1 import scene as scene1
from tests.drivers.ros2 import rig as rig2
from tests.drivers.ros2 import scene as scene2

SLOW = {"arm": {"speed": 0.15}, "belt": {"travel": 4.0}, "sorter": {"sort": 4.0}}


class RosPeer(SeeingPeer, ProcessPeer):
    """A cell on ROS."""

    actuators: ClassVar[Sequence[str]] = ("arm", "arm by action", "belt", "sorter")
    _rig: rig1.Rig | rig2.Rig
    _devices: dict[str, Any]

    def refresh(self) -> None:
        self._rig.mend()

    def close(self) -> None:
        for device in self._devices.values():
            device.close()
        self._rig.close()

    def ready(self, role: str) -> Any:
        await_ready(self._devices[role])
        return self._devices[role]

    def fresh(self, role: str) -> int:
        kind = role.split()[0]
        if kind == "sorter":
            return 1
        return self.world("belt") + 1 if kind == "belt" else 1 - self.world("arm") % 2

    def far(self, role: str) -> int:
        self._rig.tell(**SLOW[role.split()[0]])
        return self.fresh(role)

    def impossible(self, role: str) -> int:
        return {"arm": 2, "belt": self.world("belt") - 1, "sorter": 17}[role.split()[0]]

    def world(self, role: str) -> int:
        """As `Peer.world`; an arm that stands elsewhere is at viewpoint -1."""
        world = self._rig.tell()
        if role.startswith("belt"):
            return int(world["object"])
        if role.startswith("sorter"):
            return int(sum(world["bins"]))
        joints = world["joints"]
        at = (all(abs(joints[j] - x) < 0.02 for j, x in taught.items()) for taught in TAUGHT.values())
        return next((number for number, here in enumerate(at) if here), -1)

    def busy(self, role: str) -> bool:
        return bool(self._rig.tell()["busy"][role.split()[0]])

    def lose(self, role: str) -> None:
        self._rig.tell(mute=True)

    def fill(self) -> None:
        self._rig.tell(full=True)

    def stick(self) -> None:
        self._rig.tell(stuck=True)

    def overshoot(self) -> None:
        self._rig.tell(overshoot=True)

    def stray(self) -> None:
        """Let the arm stop beside its target."""
        self._rig.tell(offset=0.05)

    def spoil(self, kind: str) -> None:
        self._rig.tell(cloud=kind)

    def heard(self) -> None:
        self._rig.tell(mute=False)

    def now(self) -> float:
        return time.monotonic()

    def looked_at(self, index: int) -> None:
        self.mend()

    def mend(self) -> None:
        self._rig.mend()

    def kill(self) -> None:
        self._rig.kill(self._rig.peer)

    def restart(self) -> None:
        self._rig.start_peer()

    def hang(self) -> None:
        self._rig.freeze()

    def resume(self) -> None:
        self._rig.thaw()


class Ros1Peer(RosPeer):
    """The peer of tests/drivers/ros1."""

    def __init__(self, folder: Path) -> None:
        rig1.require_ros()
        super().__init__(folder)
        folder.mkdir(exist_ok=True)
        self._rig = rig1.Rig(folder)
        uri = self._rig.uri
        self._devices = {
            "arm": Ros1Arm(scene1.arm(uri)),
            "arm by action": Ros1Arm(scene1.arm(uri, action=True)),
            "belt": Ros1Belt(scene1.belt(uri)),
            "sorter": Ros1Sorter(scene1.sorter(uri)),
            "camera": Ros1Camera(scene1.camera_by_tf(uri)),
        }


class Ros2Peer(RosPeer):
    """The peer of tests/drivers/ros2."""

    actuators = (*RosPeer.actuators, "arm by MoveIt", "belt by service", "sorter by service")

    def __init__(self, folder: Path) -> None:
        rig2.require_ros2()
        super().__init__(folder)
        folder.mkdir(exist_ok=True)
        self._rig = self._rig2 = rig2.Rig(folder)
        domain = self._rig.domain
        self._devices = {
            "arm": Ros2Arm(scene2.arm(domain)),
            "arm by action": Ros2Arm(scene2.arm(domain, action=True)),
            "arm by MoveIt": Ros2Arm(scene2.arm_by_moveit(domain)),
            "belt": Ros2Belt(scene2.belt(domain)),
            "sorter": Ros2Sorter(scene2.sorter(domain)),
            "belt by service": Ros2ServiceBelt(scene2.belt_by_service(domain)),
            "sorter by service": Ros2ServiceSorter(scene2.sorter_by_service(domain)),
            "camera": Ros2Camera(scene2.camera_by_tf(domain)),
        }
        # The first step of a belt waits until it has stood for a while; those of the tests have less time.
        self.ready("belt by service").advance_to(self.fresh("belt by service"), "first step")

    def ready(self, role: str) -> Any:
        """As `Peer.ready`; a belt that was stopped between two objects cannot be advanced by steps."""
        if role == "belt by service":
            rig2.set_going(self._rig2, super().ready("belt"))
        return super().ready(role)
