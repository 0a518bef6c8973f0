"""A thousand objects over OPC UA, with faults on purpose in one call of a hundred."""

import resource
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.cell import Outcome, Scan
from beltsort.cell.commands import TIMEOUT
from beltsort.cell.composed import ComposedCell
from beltsort.cell.wrappers.fault_kinds import Fault
from beltsort.cell.wrappers.faults import FaultPlan, Faults
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from beltsort.geometry import BeltLayout
from beltsort.journal import Entry, Journal
from beltsort.models import paper
from beltsort.sorter import sort_objects
from tests.contract.peers import OpcuaPeer
from tests.loop.killed_run import perceive
from tests.loop.scripted_cell import ScriptedCell

OBJECTS, RATE, SEED = 1000, 0.01, 2019
MODEL = paper().replace(r_min=5)
KINDS = (Fault.NOT_DONE, Fault.LOST_ACKNOWLEDGEMENT, Fault.LATE, Fault.STALE_SCAN, Fault.WRONG_ARRIVAL)


class LabelCamera(ScriptedCell):
    """Arm and camera; labels are drawn by (seed, object at the belt end, scan, position)."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        self.stamps = [*self.stamps[-9:], not_before]
        rng = np.random.default_rng((SEED, len(self.acts)))
        labels = [rng.choice(4, p=MODEL.p_obs[j, self.viewpoint, (self.first + j) % 4]) for j in range(2)]
        return Scan(np.array([[label, 0.0, 0.0] for label in labels]), np.eye(4), stamp=not_before)


@pytest.fixture
def peer(tmp_path: Path) -> Iterator[OpcuaPeer]:
    peer = OpcuaPeer(tmp_path)
    try:
        peer.start("--speed", "200")
        yield peer
    finally:
        peer.close()


def megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


@pytest.mark.soak
def test_a_thousand_objects(tmp_path: Path, peer: OpcuaPeer) -> None:
    device, camera = peer.device(), LabelCamera(MODEL)
    faults = Faults(FaultPlan(SEED, dict.fromkeys(KINDS, RATE / len(KINDS))), len(MODEL.viewpoints))
    cell = ComposedCell(
        WrappedArm(camera, faults),
        WrappedCamera(camera, faults),
        WrappedBelt(device, faults),
        WrappedSorter(device, faults),
        *(tuple(MODEL.classes), tuple(MODEL.viewpoints), BeltLayout(positions=MODEL.positions), None),
    )
    befallen: Counter[str] = Counter()
    memory: dict[int, float] = {}

    def listener(entry: Entry) -> None:
        if entry.kind == "bad_scan" or "error" in entry.data:
            befallen[entry.kind] += 1
        if entry.kind == "decision":
            camera.first = (entry.object or 0) + 1
            memory.setdefault(entry.object or 0, megabytes())

    with Journal(tmp_path / "journal.sqlite", listener) as journal:
        report = sort_objects(
            cell, perceive, beltsort.OneObject(MODEL), MODEL, journal, objects=OBJECTS,
            operator=lambda command, reason: Outcome.NOT_DONE,
        )  # fmt: skip
    seen = peer.push("look")
    assert [decision.object for decision in report.decisions] == list(range(OBJECTS))
    assert sum(seen["bins"]) == OBJECTS, "each object in a bin, once"
    assert seen["bins"][:4] == [sum(d.label == label for d in report.decisions) for label in range(4)]
    growth = memory[OBJECTS - 1] - memory[OBJECTS // 5]
    print(
        f"\nfaults {befallen.total()} {dict(befallen)} | objects {OBJECTS} | lost 0 | memory +{growth:.1f} MB"
    )
    assert befallen.total() > OBJECTS * RATE
    assert growth < 20.0
