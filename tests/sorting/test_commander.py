"""What becomes of commands that fail."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

import beltsort
from beltsort.cell import AdvanceTo, CommandError, EmergencyStopError, Health, Outcome, SortInto
from beltsort.sorting.holds import Answer, HeldError, Hold, Operator, nobody
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Rules
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted

PAPER = beltsort.SortingModel.load("tests/fixtures/paper.json").replace(r_min=5)
IMPATIENT = Rules(retry_delays=(0.0, 0.0))
Fault = Callable[["FailingCell", str], None]


@dataclass
class FailingCell(ScriptedCell):
    """Each command first suffers the next fault that is meant for it, then acts once per id."""

    faults: dict[str, list[Fault]] = field(default_factory=dict)
    boot: int = 1
    forgotten: set[str] = field(default_factory=set)

    def health(self) -> Health:
        return Health(ready=True, boot_id=str(self.boot))

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        known = command_id in self.command_ids and command_id not in self.forgotten
        return Outcome.DONE if known else Outcome.NOT_DONE

    def _act(self, name: str, target: int, command_id: str) -> None:
        if faults := self.faults.get(name):
            faults.pop(0)(self, command_id)
        if self.outcome_of(command_id) is Outcome.NOT_DONE:
            super()._act(name, target, command_id)


def refuse(_cell: FailingCell, _command_id: str) -> None:
    raise CommandError("busy", Outcome.NOT_DONE)


def lose_the_answer(cell: FailingCell, command_id: str) -> None:
    """It acts, and nobody hears of it."""
    if cell.outcome_of(command_id) is Outcome.NOT_DONE:
        ScriptedCell._act(cell, command_id.split("-")[1], 1, command_id)
    raise CommandError("no answer", Outcome.UNKNOWN)


def lose_the_command(_cell: FailingCell, _command_id: str) -> None:
    raise CommandError("no answer", Outcome.UNKNOWN)


def restart_after_acting(cell: FailingCell, command_id: str) -> None:
    ScriptedCell._act(cell, "sort", 1, command_id)
    cell.boot, cell.forgotten = cell.boot + 1, {command_id}
    raise CommandError("connection lost", Outcome.UNKNOWN)


def press_the_emergency_stop(_cell: FailingCell, _command_id: str) -> None:
    raise EmergencyStopError("pressed", Outcome.NOT_DONE)


def certain() -> Iterator[list[int]]:
    while True:
        yield [1, 1]


def sort_two(
    folder: Path, cell: FailingCell, operator: Operator = nobody
) -> tuple[SortingReport, list[Entry]]:
    path = folder / "journal.sqlite"
    with Journal(path) as journal:
        report = sort_objects(
            *(cell, scripted(certain()), LookOnce(), PAPER, journal),
            objects=2,
            rules=IMPATIENT,
            operator=operator,
        )
    return report, read_journal(path)


@pytest.mark.parametrize("fault", [refuse, lose_the_answer, lose_the_command])
@pytest.mark.parametrize("name", ["move", "sort", "advance"])
def test_a_command_that_fails_is_done_once_all_the_same(tmp_path: Path, name: str, fault: Fault) -> None:
    cell = FailingCell(PAPER, faults={name: [fault, fault]})
    report, entries = sort_two(tmp_path, cell)
    assert [d.label for d in report.decisions] == [1, 1]
    assert [target for what, target in cell.acts if what == "sort"] == [1, 1]
    assert len(set(cell.command_ids)) == len(cell.command_ids)
    failures = [entry.data for entry in entries if entry.kind == "outcome" and "error" in entry.data]
    assert failures
    assert all("CommandError" in failure["error"] for failure in failures)


class SilentCell(FailingCell):
    """Once the sort was sent, nothing answers any more."""

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        if "sort" in command_id:
            raise CommandError("no connection", Outcome.UNKNOWN)
        return super().outcome_of(command_id)


def test_reasons_are_told_once_however_often_a_device_was_asked(tmp_path: Path) -> None:
    with pytest.raises(HeldError) as held:
        sort_two(tmp_path, SilentCell(PAPER, faults={"sort": [lose_the_command] * 9}))
    reason = held.value.hold.reason
    assert (reason.count("no answer"), reason.count("no connection")) == (1, 1), reason


def test_a_command_that_always_fails_holds_the_run(tmp_path: Path) -> None:
    cell = FailingCell(PAPER, faults={"advance": [refuse] * 3})
    with pytest.raises(HeldError, match=r"advance 1\b.*\b3 times\b.*\bbusy\b") as held:
        sort_two(tmp_path, cell)
    assert held.value.hold.command is not None
    assert held.value.hold.command.act == AdvanceTo(1)
    assert (held.value.hold.answers, held.value.hold.person) == ((), False)
    states = [e.data["state"] for e in read_journal(tmp_path / "journal.sqlite") if e.kind == "state"]
    assert states == ["Execute", "Held", "Held"]
    with Journal(tmp_path / "journal.sqlite", resume=True) as journal:
        report = resume_sorting(cell, scripted(certain()), LookOnce(), journal)
    assert [d.object for d in report.decisions] == [0, 1]
    assert [target for what, target in cell.acts if what == "advance"] == [1, 2]


@pytest.mark.parametrize("answer", [Answer.DONE, Answer.NOT_DONE])
def test_a_sort_that_a_restarted_device_forgot_is_left_to_the_operator(
    tmp_path: Path, answer: Answer
) -> None:
    asked: list[Hold] = []

    def operator(hold: Hold) -> Answer:
        asked.append(hold)
        return answer

    cell = FailingCell(PAPER, faults={"sort": [restart_after_acting]})
    report, _ = sort_two(tmp_path, cell, operator)
    assert len(asked) == 1
    assert asked[0].command is not None
    assert (asked[0].command.act, asked[0].answers) == (SortInto(1), (Answer.DONE, Answer.NOT_DONE))
    sorts = [target for what, target in cell.acts if what == "sort"]
    assert len(sorts) == (2 if answer is Answer.DONE else 3)
    assert [d.object for d in report.decisions] == [0, 1]


def test_the_emergency_stop_aborts_at_once(tmp_path: Path) -> None:
    cell = FailingCell(PAPER, faults={"sort": [press_the_emergency_stop]})
    with pytest.raises(EmergencyStopError):
        sort_two(tmp_path, cell)
    entries = read_journal(tmp_path / "journal.sqlite")
    assert [e.data["state"] for e in entries if e.kind == "state"] == ["Execute", "Aborted"]
    assert cell.stops == 4


def test_a_device_with_a_fault_gets_no_command(tmp_path: Path) -> None:
    class Faulty(FailingCell):
        def health(self) -> Health:
            return Health(ready=False, boot_id="1", fault="door open", emergency_stop=bool(self.acts))

    cell = Faulty(PAPER)
    with pytest.raises(HeldError, match=r"\bmove\b.*\bdoor open\b"):
        sort_two(tmp_path, cell)
    assert cell.acts == []
