"""Devices stop when work does not end well."""

import pytest

import beltsort
from beltsort.cell import CommandError, Outcome
from beltsort.cell.stopping import stopping
from tests.sorting.scripted_cell import ScriptedCell

PAPER = beltsort.SortingModel.load("tests/fixtures/paper.json")


class Stuck(ScriptedCell):
    """Its devices do not stop."""

    def stop(self) -> None:
        super().stop()
        raise OSError("no answer")


def test_all_goes_well() -> None:
    cell = ScriptedCell(PAPER)
    with stopping(cell):
        cell.arm.move_to(1, "move-1")
    assert cell.acts == [("move", 1)]


@pytest.mark.parametrize("failure", [KeyboardInterrupt(), CommandError("late", Outcome.UNKNOWN)])
def test_every_device_is_stopped_even_if_some_cannot_be(failure: BaseException) -> None:
    cell = Stuck(PAPER)
    with pytest.raises(type(failure)) as raised, stopping(cell):
        raise failure
    assert cell.stops == 4
    notes = raised.value.__notes__[-4:]
    assert len(notes) == 4
    assert all("no answer" in note for note in notes)
