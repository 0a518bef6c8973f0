"""Deadlines and outcomes of commands."""

import threading

import pytest

from beltsort.cell import CommandError, Outcome, within
from beltsort.sim import SimulatedCell
from tests.waiting import PATIENCE


def test_a_late_answer_is_dropped() -> None:
    release, ended = threading.Event(), threading.Event()

    def late() -> str:
        release.wait()
        ended.set()
        return "late"

    with pytest.raises(CommandError, match=r"the move\b.*\b0\.05 s\b") as error:
        within(0.05, "the move", late)
    assert error.value.outcome is Outcome.UNKNOWN
    release.set()
    assert ended.wait(PATIENCE)
    assert within(PATIENCE, "the next move", lambda: "in time") == "in time"


def test_a_failure_in_time_passes_through() -> None:
    def fail() -> None:
        raise TimeoutError("the driver's own")

    with pytest.raises(TimeoutError, match="the driver's own"):
        within(PATIENCE, "the move", fail)


def test_waiting_ends_with_the_act() -> None:
    within(100_000.0, "nothing", lambda: None)


def test_a_simulated_act_that_would_take_too_long_is_not_done_and_may_be_repeated() -> None:
    cell = SimulatedCell([0, 1])
    with pytest.raises(CommandError, match=r"sort\b.*\b3 s\b.*\b1 s\b") as error:
        cell.sort(0, "sort-1", timeout=1.0)
    assert error.value.outcome is cell.outcome_of("sort-1") is Outcome.NOT_DONE
    assert cell.bins == []
    cell.sort(0, "sort-1")
    assert cell.outcome_of("sort-1") is Outcome.DONE
    with pytest.raises(CommandError, match=r"advance\b.*\b1 s\b"):
        cell.advance_to(1, "advance-2", timeout=1.0)
    cell.advance_to(1, "advance-2")
    cell.sort(1, "sort-3")
    assert cell.bins == [(0, 0), (1, 1)]


def test_refused_commands_say_that_nothing_was_done() -> None:
    cell = SimulatedCell([0])
    cell.sort(0, "one")
    for refused in (lambda: cell.sort(0, "two"), lambda: cell.advance_to(7, "three")):
        with pytest.raises(CommandError) as error:
            refused()
        assert error.value.outcome is Outcome.NOT_DONE
    assert cell.health().ready
