"""Layers around devices."""

from collections.abc import Callable

import pytest

import beltsort
from beltsort.cell import Outcome, SortInto
from beltsort.cell.wrappers.bins import Bins
from beltsort.cell.wrappers.layer import Layer, Request, Send
from beltsort.cell.wrappers.recorder import Recorded, Recorder
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from tests.sorting.scripted_cell import ScriptedCell

PAPER = beltsort.SortingModel.load("tests/fixtures/paper.json")


def test_a_layer_that_changes_nothing_passes_every_call_on() -> None:
    cell = ScriptedCell(PAPER)
    arm, belt = WrappedArm(cell, Layer()), WrappedBelt(cell, Layer())
    camera, sorter = WrappedCamera(cell, Layer()), WrappedSorter(cell, Layer())
    assert (arm.move_to(2, "move-1"), belt.advance_to(1, "advance-2")) == (1.0, 2.0)
    sorter.sort(3, "sort-3")
    assert cell.acts == [("move", 2), ("advance", 1), ("sort", 3)]
    assert camera.scan(not_before=7.0).stamp == 7.0
    assert (sorter.outcome_of("sort-3"), sorter.outcome_of("sort-4")) == (Outcome.DONE, Outcome.NOT_DONE)
    assert arm.health() == cell.health()
    belt.stop()
    assert cell.stops == 1
    assert (arm.flange_pose(), belt.position()) == (None, None), "the cell tells neither"


class Refusing(Layer):
    """Passes no command on, and has done them all."""

    def command(self, _send: Send, _request: Request) -> float:
        raise LookupError("no")

    def outcome_of(self, _ask: Callable[[str], Outcome], _command_id: str) -> Outcome:
        return Outcome.BROKEN_OFF


def test_the_first_layer_gets_a_call_before_the_others() -> None:
    cell, calls = ScriptedCell(PAPER), list[Recorded]()
    numbers, recorder = Bins([5, 6]), Recorder("sorter", calls.append)
    WrappedSorter(cell, numbers, recorder).sort(1, "sort-1")
    WrappedSorter(cell, recorder, numbers).sort(1, "sort-2")
    assert [recorded.call.target for recorded in calls] == [6, 1]
    assert cell.acts == [("sort", 6), ("sort", 6)]
    inside = WrappedSorter(cell, recorder, Refusing())
    with pytest.raises(LookupError):
        inside.sort(0, "sort-3")
    assert calls[-1].error == "LookupError('no')"
    assert inside.outcome_of("sort-3") is Outcome.BROKEN_OFF
    assert len(cell.acts) == 2


def test_acts_in_words() -> None:
    assert str(SortInto(2)) == "sort 2"
