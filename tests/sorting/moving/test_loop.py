from collections.abc import Iterator
from dataclasses import replace
from itertools import count, pairwise
from pathlib import Path

import pytest

from beltsort import DecideAt, Move, MovingBelief, PolicyError, Wait
from beltsort.cell import EmergencyStopError, Scan
from beltsort.errors import CellError
from beltsort.sim import MovingCell
from beltsort.sorting.entries import ScanUnusable
from beltsort.sorting.holds import HeldError
from beltsort.sorting.moving.entries import DiversionTold, Fate, Looked
from beltsort.sorting.requests import Request, taking_requests, write_request
from tests.sorting.moving.runs import BELT, check_accounts, entries, plant, resume, sort


class Script:
    """A policy that takes given actions, and waits when there are no more."""

    def __init__(self, *actions: Move | Wait | DecideAt) -> None:
        self.actions: Iterator[Move | Wait | DecideAt] = iter(actions)

    def act(self, belief: MovingBelief, viewpoint: int) -> Move | Wait | DecideAt:
        return next(self.actions, Wait())


class DecideAtOnce:
    """A policy that decides each object at the exit after one look."""

    def __init__(self) -> None:
        self.looked = False

    def act(self, belief: MovingBelief, viewpoint: int) -> Move | Wait | DecideAt:
        if belief.decided[0]:
            return Wait()
        self.looked = not self.looked
        return Move(viewpoint) if self.looked else DecideAt(0, int(belief.probabilities[0].argmax()))


def test_every_object_is_told_once_and_is_in_the_bin_that_the_journal_says(tmp_path: Path) -> None:
    cell = plant()
    report = sort(tmp_path, cell)
    fates = check_accounts(tmp_path, cell)
    assert report.objects == 12
    assert report.fates[Fate.IN_BIN] == sum(fate is Fate.IN_BIN for fate in fates.values()) >= 6
    assert sum(map(sum, report.confusion)) == sum(report.bins) == report.fates[Fate.IN_BIN]
    really = [[0] * 4 for _ in range(4)]
    for cup, bin in cell.belt.in_bins.items():
        if (true := cell.true_class(cup)) is not None:
            really[bin][true] += 1
    assert [list(row) for row in report.confusion] == really


def test_a_run_sorts_on_after_another_one_of_the_same_belt(tmp_path: Path) -> None:
    """The controller remembers the diversions of the first run, and refuses others of the same objects."""
    cell, fates = plant(objects=40), []
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        fates.append(sort(tmp_path / name, cell).fates)
        assert fates[-1][Fate.IN_BIN] >= 6
    assert len(cell.belt.in_bins) == fates[0][Fate.IN_BIN] + fates[1][Fate.IN_BIN]


def test_an_object_that_nobody_decides_is_told_as_missed_and_an_empty_cup_is_not(tmp_path: Path) -> None:
    cell = plant()
    looking = Script(*[Move(0) for _ in range(200)])
    report = sort(tmp_path, cell, looking)
    fates = check_accounts(tmp_path, cell)
    empty = sum(cell.true_class(number) is None for number in range(1, 13))
    assert report.fates[Fate.MISSED] + report.fates[Fate.EMPTY] == 12
    assert abs(report.fates[Fate.EMPTY] - empty) <= 1  # the last one may not have been seen twice
    assert set(fates.values()) == {Fate.MISSED, Fate.EMPTY}


def test_a_decision_that_comes_too_late_is_told(tmp_path: Path) -> None:
    cell = plant()
    cell.belt.controller._machine = cell.machine.__class__(
        diverters=(-400_000, 500_000, 500_000, 500_000), speed=cell.machine.speed
    )
    report = sort(tmp_path, cell, DecideAtOnce())
    check_accounts(tmp_path, cell)
    assert report.fates[Fate.TOO_LATE] > 0
    assert report.bins[0] == 0


def test_a_refused_diversion_is_sent_again_until_the_bin_is_emptied(tmp_path: Path) -> None:
    cell = plant()
    steps = 0

    def check() -> None:
        nonlocal steps
        steps += 1
        if steps == 1:
            cell.belt.controller.fill()
        if steps == 60:
            cell.belt.controller.empty()

    report = sort(tmp_path, cell, DecideAtOnce(), check=check)
    check_accounts(tmp_path, cell)
    told = [entry.content for entry in entries(tmp_path) if isinstance(entry.content, DiversionTold)]
    refused = {each.number for each in told if each.retry}
    assert refused
    assert report.fates[Fate.IN_BIN] > 0
    assert report.fates[Fate.NOT_DONE] > 0
    assert "empty it" in next(each.reason for each in told if each.retry)


def test_the_emergency_stop_ends_the_run_and_the_rest_is_sorted_when_it_is_resumed(tmp_path: Path) -> None:
    cell = plant()
    steps = 0

    def check() -> None:
        nonlocal steps
        steps += 1
        if steps == 40:
            cell.world.set_speed(0.0)
            cell.belt.controller.press()

    with pytest.raises(EmergencyStopError, match="release it"):
        sort(tmp_path, cell, check=check)
    cell.belt.controller.release()
    cell.belt.start()
    resume(tmp_path, cell)
    assert set(check_accounts(tmp_path, cell).values()) <= {
        Fate.IN_BIN,
        Fate.EMPTY,
        Fate.MISSED,
        Fate.NOT_DONE,
    }


def test_a_request_to_stop_stops_the_belt_and_nothing_passes_until_the_run_is_resumed(tmp_path: Path) -> None:
    cell = plant()
    with taking_requests(tmp_path):
        write_request(tmp_path, Request.now("stop", "a test"))
        report = sort(tmp_path, cell, requests=tmp_path)
    assert report.stopped_by is not None
    assert not cell.belt.reading().moving
    cell.wait(100.0)
    cell.belt.start()
    fates = resume(tmp_path, cell).fates
    assert fates[Fate.IN_BIN] >= 6
    check_accounts(tmp_path, cell)


def test_a_belt_of_another_speed_is_refused_before_anything_is_sorted(tmp_path: Path) -> None:
    cell = plant()
    cell.belt.machine = cell.machine.__class__(diverters=cell.machine.diverters, speed=90_000)
    cell.belt.restart()
    with pytest.raises(HeldError, match=r"moves at 0\.090 m/s, expected about 0\.060"):
        sort(tmp_path, cell)


@pytest.mark.parametrize("action", [Move(7), DecideAt(0, 9), DecideAt(5, 0), "left"])
def test_an_illegal_action_is_an_error(tmp_path: Path, action: Move) -> None:
    with pytest.raises(PolicyError, match="legal are"):
        sort(tmp_path, plant(), Script(action))


def test_a_model_of_other_classes_is_an_error(tmp_path: Path) -> None:
    cell = plant()
    cell.world.config = cell.world.config.__class__(classes=("nut", "bolt", "washer", "ring"))
    with pytest.raises(CellError, match="classes"):
        sort(tmp_path, cell)


def test_scans_are_not_taken_earlier_than_planned(tmp_path: Path) -> None:
    cell = plant()
    sort(tmp_path, cell, Script(*[Move(0) for _ in range(10)]), objects=4)
    stamps = [entry.content.stamp for entry in entries(tmp_path) if isinstance(entry.content, Looked)]
    tick = BELT.seconds_per_tick
    assert tick is not None
    assert min(b - a for a, b in pairwise(stamps[1:])) >= tick - 1e-9


def test_a_scan_whose_place_on_the_belt_is_not_known_is_journalled_and_changes_nothing(
    tmp_path: Path,
) -> None:
    cell, scan = plant(), MovingCell.scan
    scans = count()

    def late(**options: float) -> Scan:
        taken = scan(cell.world, **options)
        stamp = taken.stamp + 100.0 if next(scans) == 3 else taken.stamp
        return replace(taken, stamp=stamp)

    cell.world.scan = late  # type: ignore[method-assign] # the camera of this cell alone
    sort(tmp_path, cell)
    check_accounts(tmp_path, cell)
    unusable = [entry.content for entry in entries(tmp_path) if isinstance(entry.content, ScanUnusable)]
    assert len(unusable) == 1
    assert "longest_gap" in unusable[0].error
