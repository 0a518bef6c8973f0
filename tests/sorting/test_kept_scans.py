"""The latest scans that a run keeps: bounded, each complete at once, and never in the way of the run."""

import errno
import subprocess
import sys
import warnings
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
from beltsort.sorting.kept_scans import (
    CANDIDATE,
    SCANS,
    SURROUNDINGS,
    KeptScan,
    ScanKeeper,
    kept_scans,
    scan_file,
    thinned,
)
from beltsort.sorting.loop import sort_objects
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted
from tests.waiting import wait_until

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
    ScanKeeper(tmp_path, cell, 10)(ENTRY, scan, [Cut(candidate), Cut(None)])
    path = scan_file(tmp_path, 7)
    kept = KeptScan.load(path)
    assert (kept.entry, kept.layout) == (7, cell.layout)
    assert (kept.positions == 0).sum() == CANDIDATE
    assert 500 < (kept.positions == -1).sum() <= SURROUNDINGS
    assert np.isfinite(kept.points).all()
    np.testing.assert_array_equal(kept.viewpoints, np.array(cell.poses))
    np.testing.assert_array_equal(kept.camera, cell.poses[2])
    assert np.abs(kept.points[kept.positions == -1][:, 2]).max() < 0.3  # belt and cups, in the belt frame
    spread = candidate[np.linspace(0, len(candidate) - 1, CANDIDATE).astype(int)]
    np.testing.assert_allclose(kept.points[kept.positions == 0], spread, atol=0.0005)
    assert path.stat().st_size < 50_000
    assert [file.name for file in tmp_path.rglob("*.*")] == ["000000007.npz"]


def keep_four(run: Path, keep: int, first: int = 1) -> None:
    """Keep four scans of one point, in entries from `first` on."""
    keeper = ScanKeeper(run, ScriptedCell(MODEL), keep)
    for number in range(first, first + 4):
        keeper(Entry(number, "", 0, ScanUnusable("")), Scan(np.zeros((1, 3)), np.eye(4), 0.0), [])


@pytest.mark.parametrize(("keep", "kept"), [(3, [2, 3, 4]), (1, [4]), (100, [1, 2, 3, 4]), (0, [])])
def test_the_latest_are_kept(tmp_path: Path, keep: int, kept: list[int]) -> None:
    keep_four(tmp_path, keep)
    assert kept_scans(tmp_path) == kept
    assert [KeptScan.load(scan_file(tmp_path, number)).entry for number in kept] == kept


def test_a_resumed_run_goes_on_with_them(tmp_path: Path) -> None:
    keep_four(tmp_path, 10)
    (tmp_path / SCANS / "000000005.npz.new-123").write_bytes(b"of a killed process")
    assert kept_scans(tmp_path) == [1, 2, 3, 4]
    keep_four(tmp_path, 5, first=5)
    assert kept_scans(tmp_path) == [4, 5, 6, 7, 8]
    assert len(list((tmp_path / SCANS).iterdir())) == 5


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
    scan, keep = cell.scan(not_before=0.0), ScanKeeper(tmp_path, cell, 5)
    seconds = []
    for _ in range(10):
        began = perf_counter()
        keep(ENTRY, scan, [Cut(np.zeros((2000, 3)))])
        seconds.append(perf_counter() - began)
    assert min(seconds) < 0.02  # a few per cent of what the scan's own perception takes


ENDLESS = """
import sys
from pathlib import Path
from tests.sorting.test_kept_scans import keep_four
for first in range(1, 10**8, 4):
    keep_four(Path(sys.argv[1]), 20, first)
"""


@pytest.mark.process
def test_a_killed_process_leaves_scans_that_can_be_read(tmp_path: Path) -> None:
    writer = subprocess.Popen([sys.executable, "-c", ENDLESS, str(tmp_path)])
    wait_until(lambda: len(kept_scans(tmp_path)) >= 20, "scans")
    writer.kill()
    writer.wait()
    kept = kept_scans(tmp_path)
    assert 20 <= len(kept) <= 21  # the oldest is dropped after the latest is complete
    assert [KeptScan.load(scan_file(tmp_path, number)).entry for number in kept] == kept


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
            scan_listener=Full(tmp_path, ScriptedCell(MODEL), 5),
        )
    assert len(report.decisions) == 3
    assert [entry.kind for entry in read_journal(path)].count("unheard") == 1


def test_a_full_disk_leaves_the_former_scans_and_is_told_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell, path = ScriptedCell(MODEL), scan_file(tmp_path, ENTRY.number)
    keep, scan = ScanKeeper(tmp_path, cell, 1), Scan(np.zeros((4, 3)), np.eye(4), 0.0)
    keep(ENTRY, scan, [])
    before = path.read_bytes()

    def full(self: Path, _data: bytes) -> int:
        self.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for number in (8, 9):
            keep(Entry(number, "", 0, ScanUnusable("")), scan, [])
    assert [str(each.message).partition(" (")[0] for each in told] == [
        f"the scan cannot be kept in {tmp_path / SCANS}"
    ]
    assert path.read_bytes() == before
    assert list((tmp_path / SCANS).iterdir()) == [path]
    monkeypatch.undo()
    keep(Entry(10, "", 0, ScanUnusable("")), scan, [])
    assert kept_scans(tmp_path) == [10]
    assert KeptScan.load(scan_file(tmp_path, 10)).entry == 10
