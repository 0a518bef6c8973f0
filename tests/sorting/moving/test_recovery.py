import itertools
import random
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from beltsort.cell import Diversion
from beltsort.sorting.entries import AnyContent
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.moving.entries import Anchored, Fate
from beltsort.sorting.moving.loop import resume_moving, sort_moving
from beltsort.sorting.moving.state import MovingState
from beltsort.sorting.requests import Request, taking_requests, write_request
from tests.sorting.moving.cells import MovingPlant, Perception
from tests.sorting.moving.runs import BELT, RULES, check_accounts, entries, planner, plant, resume, sort


class Killed(BaseException):
    """Stands for a kill: nothing that a process would do afterwards is done."""


class DyingJournal(Journal):
    """A journal whose process is killed when it has written so many entries."""

    lives: int

    def append(self, content: AnyContent) -> Entry:
        if self.lives == 0:
            raise Killed
        self.lives -= 1
        return super().append(content)


def dying(cell: MovingPlant, folder: Path, lives: int, *, resumed: bool = False, objects: int = 12) -> None:
    """Sort until the process is killed; the belt moves on."""
    stop, cell.belt.stop = cell.belt.stop, lambda: None  # type: ignore[method-assign] # a killed process stops nothing
    try:
        with DyingJournal(folder / "journal.sqlite", resume=resumed) as journal:
            journal.lives = lives
            if resumed:
                resume_moving(cell, Perception(cell), planner(), journal, rules=RULES)
            else:
                sort_moving(cell, Perception(cell), planner(), BELT, journal, objects=objects, rules=RULES)
    finally:
        cell.belt.stop = stop  # type: ignore[method-assign] # the one it had


@pytest.mark.parametrize("lives", [3, 5, 6, 9, 14, 20, 27, 35, 50])
@pytest.mark.parametrize("away", [0.1, 7.0])
def test_a_run_that_was_killed_tells_what_has_passed_and_sorts_the_rest(
    tmp_path: Path, lives: int, away: float
) -> None:
    cell = plant()
    with pytest.raises(Killed):
        dying(cell, tmp_path, lives)
    cell.wait(away)  # the belt moves on
    for again in (4, 11, 23):
        with suppress(Killed):  # it may have come to its end
            dying(cell, tmp_path, again, resumed=True)
        cell.wait(away / 4.0)
    resume(tmp_path, cell)
    fates = Counter(check_accounts(tmp_path, cell).values())
    assert set(fates) <= {Fate.IN_BIN, Fate.EMPTY, Fate.MISSED}


def test_objects_on_the_belt_when_its_controller_restarts_are_told_and_tracked_again(tmp_path: Path) -> None:
    cell = plant(objects=20)
    steps = 0

    def check() -> None:
        nonlocal steps
        steps += 1
        if steps == 50:
            cell.belt.restart()

    before = dict(cell.belt.in_bins)
    sort(tmp_path, cell, check=check)
    fates = Counter(check_accounts(tmp_path, cell).values())
    assert before == {}
    assert fates[Fate.LOST] > 0
    assert fates[Fate.IN_BIN] > 3
    anchors = [entry.content for entry in entries(tmp_path) if entry.kind == "anchor"]
    assert len(anchors) == 2


@pytest.mark.parametrize(("slipped", "killed"), [(3.0, False), (-0.3, False), (-0.9, True)])
def test_after_a_jump_of_the_encoder_the_run_goes_on_only_with_a_restarted_controller(
    tmp_path: Path, slipped: float, killed: bool
) -> None:
    cell, steps = plant(objects=20), 0

    def check() -> None:
        nonlocal steps
        steps += 1
        if steps == 50 and killed:
            raise Killed
        if steps == 50:
            cell.belt.slipped = slipped

    with pytest.raises(Killed if killed else HeldError):
        sort(tmp_path, cell, check=check)
    cell.belt.slipped = slipped
    for _ in range(2):
        cell.belt.start()
        with pytest.raises(HeldError, match="restart the controller, then resume"):
            resume(tmp_path, cell)
    assert [entry.kind for entry in entries(tmp_path)].count("jump") == 1
    cell.belt.slipped = 0.0
    cell.belt.restart()
    cell.belt.start()
    resume(tmp_path, cell)
    fates = Counter(check_accounts(tmp_path, cell).values())
    assert fates[Fate.LOST] + fates[Fate.UNKNOWN] > 0
    assert fates[Fate.IN_BIN] > 3


def cup_at(cell: MovingPlant, anchor: Anchored, began: float) -> int:
    """The cup that would be object 0 if numbers had never been lost."""
    return round((anchor.origin + began) / cell.layout.spacing) - anchor.first


def test_what_may_have_passed_before_the_controller_restarted_is_told(tmp_path: Path) -> None:
    cell = plant(objects=60)
    with pytest.raises(Killed):
        dying(cell, tmp_path, 30, objects=40)
    cell.wait(30.0)  # the belt moves on by ten places, and nobody looks
    cell.belt.restart()
    cell.wait(15.0)  # and by five, of which the new start of the controller knows
    report = resume(tmp_path, cell)
    told = [entry.content for entry in entries(tmp_path)]
    first, second = (content for content in told if isinstance(content, Anchored))
    passed = cup_at(cell, second, cell.belt.began) - cup_at(cell, first, 0.0)
    assert 5 < passed <= report.uncounted <= passed + 2


def test_what_passes_on_a_belt_that_somebody_starts_while_the_run_is_down_is_told(tmp_path: Path) -> None:
    cell, checks = plant(objects=60), itertools.count()

    def check() -> None:
        if next(checks) == 20:
            write_request(tmp_path, Request.now("stop", "a test"))

    with taking_requests(tmp_path):
        sort(tmp_path, cell, requests=tmp_path, objects=20, check=check)
    cell.wait(10.0)
    cell.belt.start()
    cell.wait(30.0)
    cell.belt.restart()
    report = resume(tmp_path, cell)
    first, second = (entry.content for entry in entries(tmp_path) if isinstance(entry.content, Anchored))
    passed = cup_at(cell, second, cell.belt.began) - cup_at(cell, first, 0.0)
    assert 0 < passed <= report.uncounted


@settings(deadline=None, max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 10_000))
def test_lost_requests_and_replies_lose_no_object_and_sort_none_twice(
    tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    folder, cell = tmp_path_factory.mktemp("run"), plant()
    rng = random.Random(seed)
    cell.belt.unreachable = lambda what: what != "STOP" and rng.random() < 0.1
    cell.belt.lost = lambda what: what != "STOP" and rng.random() < 0.1
    run: Callable[..., object] = sort
    for _ in range(20):
        try:
            run(folder, cell)
            break
        except HeldError:
            run = resume
            cell.belt.start()
    else:
        pytest.fail("the run was held 20 times")
    fates = check_accounts(folder, cell)
    assert set(fates.values()) <= {Fate.IN_BIN, Fate.EMPTY, Fate.MISSED, Fate.NOT_DONE}


def test_the_state_after_a_rotation_of_the_journal_is_that_of_all_entries(tmp_path: Path) -> None:
    cell = plant()
    with Journal(tmp_path / "journal.sqlite", largest=60_000) as journal:
        sort_moving(cell, Perception(cell), planner(), BELT, journal, objects=12, rules=RULES)
    check_accounts(tmp_path, cell)
    every = entries(tmp_path)
    last = max(n for n, entry in enumerate(every) if entry.kind == "moving_snapshot")
    whole = MovingState.after(entry for entry in every if entry.kind != "moving_snapshot")
    assert MovingState.after(every[last:]).snapshot() == whole.snapshot()


def test_a_diversion_has_a_final_state_unless_it_is_queued_or_unknown() -> None:
    assert [state for state in Diversion if not state.final] == [Diversion.QUEUED, Diversion.UNKNOWN]
