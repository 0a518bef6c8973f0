"""Back-ends that live in our own process: they cannot be killed, so what fails is what stands between."""

from abc import abstractmethod
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from beltsort.cell import Scan
from beltsort.cell.wrappers.dry_run import DryRun
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from beltsort.cellfile.dry_run import OVERHEAD, Absent, EmptyBeltCamera
from beltsort.drivers.replay import Replay
from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout
from beltsort.perception import Finding, segment
from beltsort.sim import Camera, CellConfig, SimulatedCell
from beltsort.testing.fault_kinds import Fault
from beltsort.testing.faults import FaultPlan, Faults
from tests.contract.peer import SeeingPeer
from tests.contract.record import SPOILT, replayed

SEED = 7
VERBS = {"arm": "move_to", "belt": "advance_to", "sorter": "sort", "camera": "scan"}
WRAPPERS: dict[str, Any] = {
    "arm": WrappedArm,
    "belt": WrappedBelt,
    "sorter": WrappedSorter,
    "camera": WrappedCamera,
}
SPOILING = {
    "stale": Fault.STALE_SCAN,
    "empty": Fault.EMPTY_SCAN,
    "nan": Fault.NAN_SCAN,
    "truncated": Fault.TRUNCATED_SCAN,
}


@dataclass(frozen=True)
class Upcoming(FaultPlan):
    """The fault of the next call of each command."""

    waiting: dict[str, Fault] = field(default_factory=dict)

    def fault(self, command: str, number: int) -> Fault | None:
        return self.waiting.pop(command, None)


class InProcessPeer(SeeingPeer):
    """A back-end behind the faults that a cell file can ask for."""

    viewpoints = 2

    def refresh(self) -> None:
        self.plan = Upcoming(SEED)
        self.faults = Faults(self.plan, self.viewpoints)
        self.devices = self.made()

    @abstractmethod
    def made(self) -> dict[str, Any]:
        """Return new devices, by their role."""

    def close(self) -> None:
        pass

    def ready(self, role: str) -> Any:
        return WRAPPERS[role](self.devices[role], self.faults)

    def fail(self, role: str, fault: Fault) -> None:
        """Let the next command of a device fail."""
        self.plan.waiting[VERBS[role]] = fault

    def lose(self, role: str) -> None:
        self.fail(role, Fault.LOST_ACKNOWLEDGEMENT)

    def fill(self) -> None:
        self.fail("sorter", Fault.FULL_BIN)

    def spoil(self, kind: str) -> None:
        self.fail("camera", SPOILING[kind])

    def heard(self) -> None:
        pass

    def mend(self) -> None:
        self.plan.waiting.clear()

    def impossible(self, role: str) -> int:
        return {"arm": self.viewpoints, "belt": self.world("belt") - 1, "sorter": 17}[role]


class SimulatedPeer(InProcessPeer):
    """The simulated cell; its clock counts the steps of the belt."""

    actuators = ("arm", "belt", "sorter")
    viewpoints = 3
    config = CellConfig(
        camera=Camera(width=64, height=48, focal=57.0),
        move_seconds=0.0,
        scan_seconds=0.0,
        sort_seconds=0.0,
        advance_seconds=1.0,
    )

    def device(self) -> SimulatedCell:
        return SimulatedCell([0] * 50)

    def made(self) -> dict[str, Any]:
        self.cell = SimulatedCell([0] * 50, self.config, SEED)
        return dict.fromkeys(WRAPPERS, self.cell)

    def fresh(self, role: str) -> int:
        if role == "sorter" and len(self.cell.bins) > self.world("belt"):
            self.cell.advance_to(self.world("belt") + 1, f"test-{self.cell.clock}")
        return {"arm": (self.world("arm") + 1) % 3, "belt": self.world("belt") + 1, "sorter": 1}[role]

    def world(self, role: str) -> int:
        if role == "arm":
            seen = self.cell.scan(not_before=0.0).world_from_camera
            return [np.array_equal(seen, at.pose()) for at in self.config.viewpoints].index(True)
        return round(self.cell.clock) if role == "belt" else len(self.cell.bins)

    def perceive(self, scan: Scan) -> None:
        segment(scan, self.config.layout)


class DryRunPeer(InProcessPeer):
    """Nothing is there: the world is what was said of it."""

    actuators = ("arm", "belt", "sorter")

    def made(self) -> dict[str, Any]:
        self.said: list[str] = []
        acting = {
            role: WRAPPERS[role](Absent(), DryRun(self.said.append)) for role in ("arm", "belt", "sorter")
        }
        return {**acting, "camera": EmptyBeltCamera(OVERHEAD)}

    def fresh(self, role: str) -> int:
        return {"arm": 1 - self.world("arm"), "belt": self.world("belt") + 1, "sorter": 1}[role]

    def world(self, role: str) -> int:
        targets = [int(line.partition("(")[2].partition(")")[0]) for line in self.said if VERBS[role] in line]
        return len(targets) if role == "sorter" else (targets or [0])[-1]

    def perceive(self, scan: Scan) -> None:
        if set(segment(scan, BeltLayout()).findings) != {Finding.EMPTY}:
            raise CloudError("not all of the empty belt is seen")


class ReplayPeer(InProcessPeer):
    """A bag, played back: the world is what its next scan shows."""

    actuators = ("arm", "belt")

    def made(self) -> dict[str, Any]:
        self.cell = self.opened("good")
        self.cell.move_to(0, "test-first")
        return dict.fromkeys(("arm", "belt", "camera"), self.cell)

    def opened(self, kind: str) -> Replay:
        if hasattr(self, "cell"):
            self.cell.close()
        self.kind = kind
        return replayed(self.folder, kind)

    def close(self) -> None:
        self.cell.close()

    def fresh(self, role: str) -> int:
        return 1 - self.world("arm") if role == "arm" else self.world("belt") + 1

    def world(self, role: str) -> int:
        x, y, _ = self.cell.scan(not_before=0.0).world_from_camera[:3, 3]
        return int(x if role == "arm" else y)

    def now(self) -> float:
        return 2.0 if self.kind == "stale" else 0.0

    def spoil(self, kind: str) -> None:
        """Play back a bag with one such scan, then good ones."""
        assert kind in SPOILT
        self.cell = self.opened(kind)
        self.cell.move_to(0, "test-first")
        self.devices["camera"] = self.cell
