"""A thousand objects over OPC UA and over ROS 2, with faults on purpose in one call of a hundred."""

import resource
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest

import beltsort
from beltsort.cell import Belt, EmergencyStopError, Scan, Sorter
from beltsort.cell.commands import TIMEOUT
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from beltsort.cellfile.composed import ComposedCell
from beltsort.drivers.ros2 import Ros2Belt, Ros2Sorter
from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout
from beltsort.models import paper
from beltsort.sorting.holds import Answer, Hold
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.report import SortingReport
from beltsort.testing.fault_kinds import Fault
from beltsort.testing.faults import FaultPlan, Faults
from tests.account import Account
from tests.contract.peers import OpcuaPeer
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig, require_ros2
from tests.sorting.killed_run import perceive
from tests.sorting.scripted_cell import Glimpsed, ScriptedCell
from tests.waiting import PATIENCE

OBJECTS, SEED, HUNDRED = 1000, 2019, 100
MODEL = paper().replace(r_min=5)
STARTS = 100
"""How often the run may start: again after each emergency stop, once it is released."""


@dataclass(frozen=True)
class OneOfEveryHundred(FaultPlan):
    """Of every hundred calls of a command one fails: which, and the order of the kinds, by chance."""

    calls: Counter[str] = field(default_factory=Counter)
    befallen: Counter[Fault] = field(default_factory=Counter)

    def fault(self, command: str, number: int) -> Fault | None:
        self.calls[command] += 1
        hundred, place = divmod(number - 1, HUNDRED)
        rng = self.generator(command, hundred)
        if rng.integers(HUNDRED) != place:
            return None
        kinds = [kind for kind in Fault if command in kind.affected]
        turn, among = divmod(hundred, len(kinds))
        kind = Fault(self.generator(command, 10**6 + turn).permutation(kinds)[among])
        self.befallen[kind] += 1
        return kind


class LabelCamera(ScriptedCell):
    """Arm and camera; labels are drawn by (seed, object at the belt end, scan, position)."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        self.stamps = [*self.stamps[-9:], not_before]
        rng = np.random.default_rng((SEED, len(self.acts)))
        labels = [rng.choice(4, p=MODEL.p_obs[j, self.viewpoint, (self.first + j) % 4]) for j in range(2)]
        return Scan(np.array([[label, 0.0, 0.0] for label in labels]), np.eye(4), stamp=not_before)


@dataclass(frozen=True)
class Plant:
    """Belt and sorter, how many objects an onlooker sees in each bin, and a person who moves the belt.

    `bring` takes a belt that was stopped between two objects to one of them.
    """

    name: str
    belt: Belt
    sorter: Sorter
    bins: Callable[[], list[int]]
    bring: Callable[[int], object]


def over_opcua(folder: Path) -> Iterator[Plant]:
    with closing(OpcuaPeer(folder)) as peer:
        peer.start("--speed", "200")
        device = peer.device()
        yield Plant("Opcua soak", device, device, lambda: list(peer.push("look")["bins"]), device.home)


def over_ros2(folder: Path) -> Iterator[Plant]:
    require_ros2()
    with closing(Rig(folder)) as rig:
        rig.tell(travel=0.02, sort=0.02)
        with Ros2Belt(scene.belt(rig.domain)) as belt, Ros2Sorter(scene.sorter(rig.domain)) as sorter:

            def bring(index: int) -> None:
                belt.advance_to(index, uuid4().hex, timeout=PATIENCE)

            yield Plant("Ros2 soak", belt, sorter, lambda: list(rig.tell()["bins"]), bring)


@pytest.fixture(params=[over_opcua, over_ros2], ids=["Opcua", "Ros2"])
def plant(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Plant]:
    yield from request.param(tmp_path)


def megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


class Run:
    """The run of all objects, and the operator who looks at the bins when asked."""

    def __init__(self, folder: Path, plant: Plant) -> None:
        self.camera = LabelCamera(MODEL)
        self.plan = OneOfEveryHundred(SEED)
        faults = Faults(self.plan, len(MODEL.viewpoints))
        self.cell = ComposedCell(
            WrappedArm(self.camera, faults),
            WrappedCamera(self.camera, faults),
            WrappedBelt(plant.belt, faults),
            WrappedSorter(plant.sorter, faults),
            *(tuple(MODEL.classes), tuple(MODEL.viewpoints), BeltLayout(positions=MODEL.positions), None),
        )
        self._plant, self._path = plant, folder / "journal.sqlite"
        self.memory: dict[int, float] = {}
        self.starts = 0

    @property
    def bins(self) -> list[int]:
        return self._plant.bins()

    def finish(self) -> SortingReport:
        while True:
            try:
                return self._start()
            except EmergencyStopError:
                assert self.starts < STARTS
                assert self.cell.belt.health().emergency_stop  # and then somebody releases it

    def _start(self) -> SortingReport:
        self.starts += 1
        policy = beltsort.OneObject(MODEL)
        with Journal(self._path, self._listen, resume=self.starts > 1) as journal:
            if self.starts > 1:
                return resume_sorting(self.cell, perceived, policy, journal, operator=self._told)
            return sort_objects(
                self.cell, perceived, policy, MODEL, journal, objects=OBJECTS, operator=self._told
            )

    def _listen(self, entry: Entry) -> None:
        if entry.kind == "decision":
            self.camera.first = (entry.object or 0) + 1
            self.memory.setdefault(entry.object or 0, megabytes())

    def _told(self, hold: Hold) -> Answer | None:
        """Look: what was decided is in its bin, or not."""
        if not hold.answers:
            if any(way.home is not None for way in hold.ways):
                self._plant.bring(self.camera.first)
            return None
        assert hold.answers == (Answer.DONE, Answer.NOT_DONE), hold
        return Answer.DONE if sum(self.bins) == self.camera.first else Answer.NOT_DONE


def perceived(scan: Scan) -> Sequence[Glimpsed]:
    if scan.points.shape != (2, 3) or not np.isfinite(scan.points).all():
        raise CloudError("expected a label for each of two positions")
    return perceive(scan)


@pytest.mark.soak
def test_a_thousand_objects(tmp_path: Path, plant: Plant, account: Account) -> None:
    run = Run(tmp_path, plant)
    report = run.finish()
    calls, befallen = run.plan.calls.total(), run.plan.befallen
    growth = run.memory[OBJECTS - 1] - run.memory[OBJECTS // 5]
    decided = Counter(decision.label for decision in report.decisions)
    astray = sum(abs(seen - decided[label]) for label, seen in enumerate(run.bins))
    account.injected(plant.name, befallen.total())
    account.lost(plant.name, max(astray, OBJECTS - sum(run.bins)))
    print(f"\nobjects {OBJECTS} | calls {calls} {dict(run.plan.calls)} | starts {run.starts}")
    kinds = ", ".join(f"{kind} {number}" for kind, number in befallen.most_common())
    print(f"faults {befallen.total()} ({befallen.total() / calls:.2%}): {kinds}")
    print(f"lost {OBJECTS - sum(run.bins)} | in another bin than decided {astray} | memory +{growth:.1f} MB")
    assert [decision.object for decision in report.decisions] == list(range(OBJECTS))
    assert sum(run.bins) == OBJECTS, "each object in a bin, once"
    assert astray == 0
    assert befallen.total() == pytest.approx(calls / HUNDRED, rel=0.1)
    assert set(befallen) == set(Fault), "every kind has come"
    assert growth < 20.0
