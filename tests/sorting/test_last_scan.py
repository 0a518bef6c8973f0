"""The last scan that a run keeps: bounded, replaced at once, and never in the way of the run."""

import errno
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest

import beltsort
from beltsort.cell import Scan
from beltsort.geometry import BeltLayout, Points
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sorting.entries import ScanUnusable
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.last_scan import CANDIDATE, SURROUNDINGS, KeptScan, ScanKeeper, thinned
from beltsort.sorting.loop import sort_objects
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted

MODEL = beltsort.SortingModel.load("tests/fixtures/paper.json")
ENTRY = Entry(7, "", 0, ScanUnusable(""))


@dataclass(frozen=True)
class Cut:
    """A perceived position with its candidate."""

    points: Points | None
    label: int | None = 0
    empty: bool = False
    finding: str = "object"


def test_a_scan_is_thinned_out(tmp_path: Path) -> None:
    cell = SimulatedCell([0, 1], CellConfig(), seed=1)
    scan = cell.scan(not_before=cell.move_to(2, "m"))
    rng = np.random.default_rng(0)
    candidate = rng.random((5000, 3))
    path = tmp_path / "scan.npz"
    ScanKeeper(path, cell)(ENTRY, scan, [Cut(candidate), Cut(None)])
    kept = KeptScan.load(path)
    assert (kept.entry, kept.layout) == (7, cell.layout)
    assert (kept.positions == 0).sum() == CANDIDATE
    assert 500 < (kept.positions == -1).sum() <= SURROUNDINGS
    assert np.isfinite(kept.points).all()
    np.testing.assert_array_equal(kept.viewpoints, np.array(cell.poses))
    np.testing.assert_array_equal(kept.camera, cell.poses[2])
    assert np.abs(kept.points[kept.positions == -1][:, 2]).max() < 0.3  # belt and cups, in the belt frame
    assert path.stat().st_size < 200_000
    assert [file.name for file in tmp_path.iterdir()] == ["scan.npz"]


@pytest.mark.parametrize("shape", [(0, 3), (1, 3), (37, 3), (480, 640, 3), (2_000_000, 3)])
def test_its_size_is_bounded(shape: tuple[int, ...]) -> None:
    points = np.random.default_rng(0).uniform(-0.2, 0.2, shape)
    scan = Scan(points, np.eye(4), 0.0)
    cut = [Cut(points.reshape(-1, 3)), Cut(None)]
    kept, positions = thinned(scan, cut, BeltLayout())
    assert len(kept) == len(positions) <= SURROUNDINGS + CANDIDATE
    assert kept.dtype == np.float32


def test_it_takes_a_few_milliseconds(tmp_path: Path) -> None:
    cell = SimulatedCell([0, 1], CellConfig(), seed=1)
    scan, keep = cell.scan(not_before=0.0), ScanKeeper(tmp_path / "scan.npz", cell)
    seconds = []
    for _ in range(10):
        began = perf_counter()
        keep(ENTRY, scan, [Cut(np.zeros((2000, 3)))])
        seconds.append(perf_counter() - began)
    assert min(seconds) < 0.02  # a few per cent of what the scan's own perception takes


class Full(ScanKeeper):
    """A keeper whose disk is full."""

    def __call__(self, entry: Entry, scan: Scan, perceived: Sequence[object]) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")


def test_a_run_goes_on_without_it(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        report = sort_objects(
            *(ScriptedCell(MODEL), scripted([[0, 1]] * 9), LookOnce(), MODEL, journal),
            objects=3,
            scan_listener=Full(tmp_path / "scan.npz", ScriptedCell(MODEL)),
        )
    assert len(report.decisions) == 3
    assert [entry.kind for entry in read_journal(path)].count("unheard") == 1


def test_a_full_disk_leaves_the_former_scan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cell, path = ScriptedCell(MODEL), tmp_path / "scan.npz"
    keep, scan = ScanKeeper(path, cell), Scan(np.zeros((4, 3)), np.eye(4), 0.0)
    keep(ENTRY, scan, [])
    before = path.read_bytes()

    def full(self: Path, _data: bytes) -> int:
        self.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    keep(Entry(8, "", 0, ScanUnusable("")), scan, [])
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
    monkeypatch.undo()
    keep(Entry(9, "", 0, ScanUnusable("")), scan, [])
    assert KeptScan.load(path).entry == 9
