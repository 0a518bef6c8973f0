"""How runs go on: attempts with ids of their own, answers that are honoured, belts that are asked."""

import re
import signal
from dataclasses import dataclass, field
from pathlib import Path

import pytest

import beltsort
from beltsort.cell import AdvanceTo, CommandError, EmergencyStopError, Health, MoveTo, Outcome, SortInto
from beltsort.cell.protocols import NOWHERE
from beltsort.sorting.command import Command
from beltsort.sorting.commander import STEPS, Step
from beltsort.sorting.holds import NUMBER, Answer, HeldError, Hold, Operator, nobody
from beltsort.sorting.interrupts import Interrupted, Interrupts
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Rules
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted
from tests.sorting.test_commander import certain

PAPER = beltsort.SortingModel.load("tests/fixtures/paper.json").replace(r_min=5)
RULES = Rules(retry_delays=(0.0, 0.0, 0.0))
RECOVERY = Path("docs/recovery.md")


@dataclass
class Controller(ScriptedCell):
    """Belt and sorter that remember ids: one that was broken off never acts again under its id."""

    memory: dict[str, Outcome] = field(default_factory=dict)
    breaks: dict[str, list[type[CommandError]]] = field(default_factory=dict)
    at: int = 0
    unreachable: int = 0
    pressed: bool = False
    asked: list[str] = field(default_factory=list)

    def health(self) -> Health:
        self.reach("health")
        return Health(ready=not self.pressed, boot_id="1", emergency_stop=self.pressed)

    def position(self) -> int:
        self.reach("position")
        return self.at

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        self.reach("outcome_of")
        return self.memory.get(command_id, Outcome.NOT_DONE)

    def reach(self, what: str) -> None:
        self.asked.append(what)
        if self.unreachable:
            self.unreachable -= 1
            raise CommandError("the network is down", Outcome.NOT_DONE)

    def _act(self, name: str, target: int, command_id: str) -> None:
        known = self.memory.get(command_id)
        if known is Outcome.BROKEN_OFF:
            raise CommandError("it was broken off, and never acts again", Outcome.BROKEN_OFF)
        if known is None and (kinds := self.breaks.get(name)):
            kind = kinds.pop(0)
            self.memory[command_id] = Outcome.BROKEN_OFF
            self.pressed = kind is EmergencyStopError
            self.at = NOWHERE if name == "advance" else self.at
            raise kind("stopped on the way", Outcome.BROKEN_OFF)
        super()._act(name, target, command_id)
        self.memory[command_id] = Outcome.DONE
        self.at = target if name == "advance" else self.at


def begin(folder: Path, cell: Controller, operator: Operator = nobody, first: int = 0) -> SortingReport:
    with Journal(folder / "journal.sqlite") as journal:
        return sort_objects(
            *(cell, scripted(certain()), LookOnce(), PAPER, journal),
            objects=2,
            first=first,
            rules=RULES,
            operator=operator,
        )


def go_on(folder: Path, cell: Controller, operator: Operator = nobody) -> SortingReport:
    with Journal(folder / "journal.sqlite", resume=True) as journal:
        return resume_sorting(
            *(cell, scripted(certain()), LookOnce(), journal), rules=RULES, operator=operator
        )


def entries(folder: Path, kind: str) -> list[Entry]:
    return [entry for entry in read_journal(folder / "journal.sqlite") if entry.kind == kind]


def attempts(folder: Path, name: str) -> list[str]:
    """Return the ids of a kind of command, without the run's name."""
    commands = [entry.data["command"] for entry in entries(folder, "intent")]
    return [command["id"].split("-", 1)[1] for command in commands if command["name"] == name]


def sorts(cell: Controller) -> list[int]:
    return [target for name, target in cell.acts if name == "sort"]


@pytest.mark.parametrize("kind", [CommandError, EmergencyStopError])
def test_an_advance_that_was_broken_off_is_sent_again_under_a_new_id(
    tmp_path: Path, kind: type[CommandError]
) -> None:
    cell = Controller(PAPER, breaks={"advance": [kind]})
    if kind is EmergencyStopError:
        with pytest.raises(EmergencyStopError):
            begin(tmp_path, cell)
        cell.pressed = False  # somebody releases it
        report = go_on(tmp_path, cell)
    else:
        report = begin(tmp_path, cell)
    assert [decision.object for decision in report.decisions] == [0, 1]
    assert attempts(tmp_path, "advance")[:2] == ["advance-4", "advance-4.2"]
    assert len(sorts(cell)) == 2


@pytest.mark.parametrize("answer", [Answer.DONE, Answer.NOT_DONE])
@pytest.mark.parametrize("kind", [CommandError, EmergencyStopError])
def test_what_a_person_says_of_a_sort_that_was_broken_off_is_honoured(
    tmp_path: Path, kind: type[CommandError], answer: Answer
) -> None:
    cell = Controller(PAPER, breaks={"sort": [kind]})
    with pytest.raises((HeldError, EmergencyStopError)):
        begin(tmp_path, cell)
    cell.pressed = False
    asked: list[Hold] = []

    def operator(hold: Hold) -> Answer:
        asked.append(hold)
        return answer

    report = go_on(tmp_path, cell, operator)
    assert [set(hold.answers) for hold in asked] == [{Answer.DONE, Answer.NOT_DONE}]
    assert asked[0].person
    assert [decision.object for decision in report.decisions] == [0, 1]
    assert len(sorts(cell)) == (1 if answer is Answer.DONE else 2)
    assert attempts(tmp_path, "sort")[:2] == (
        ["sort-3", "sort-7"] if answer is Answer.DONE else ["sort-3", "sort-3.2"]
    )
    (answered,) = entries(tmp_path, "told")
    assert answered.data["outcome"] == answer.value.replace("-", " ")


def test_no_answer_is_no_answer(tmp_path: Path) -> None:
    cell = Controller(PAPER, breaks={"sort": [CommandError]})
    with pytest.raises(HeldError):
        begin(tmp_path, cell, lambda _hold: None)
    assert entries(tmp_path, "told") == []
    assert sorts(cell) == []


def test_an_answer_outlives_another_hold(tmp_path: Path) -> None:
    cell = Controller(PAPER, breaks={"sort": [CommandError]})
    with pytest.raises(HeldError):
        begin(tmp_path, cell)
    cell.at = NOWHERE  # and meanwhile the belt has forgotten where it stands

    def operator(hold: Hold) -> Answer | None:
        return Answer.NOT_DONE if hold.answers else nobody(hold)

    with pytest.raises(HeldError, match=r"\bno object\b"):
        go_on(tmp_path, cell, operator)
    cell.at = 0
    go_on(tmp_path, cell)
    assert len(entries(tmp_path, "told")) == 1
    assert len(sorts(cell)) == 2


def test_a_refusal_needs_no_person_even_if_the_device_forgets_it(tmp_path: Path) -> None:
    class Full(Controller):
        full = True

        def _act(self, name: str, target: int, command_id: str) -> None:
            if name == "sort" and self.full:
                raise CommandError("the bin is full", Outcome.NOT_DONE)
            super()._act(name, target, command_id)

        def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
            return self.memory.get(command_id, Outcome.UNKNOWN)

    cell = Full(PAPER)
    with pytest.raises(HeldError, match=r"\bfull\b"):
        begin(tmp_path, cell)
    cell.full = False
    assert len(go_on(tmp_path, cell).decisions) == 2
    assert len(sorts(cell)) == 2


def test_a_belt_that_is_moved_while_a_device_is_not_ready_is_noticed(tmp_path: Path) -> None:
    """The door is open when a sort is repeated; whoever closes it has moved the belt."""

    class Door(Controller):
        tries, closed = 0, True

        def _act(self, name: str, target: int, command_id: str) -> None:
            if name == "sort" and self.tries == 0:
                self.tries, self.closed = 1, False
                raise CommandError("the door was opened", Outcome.NOT_DONE)
            super()._act(name, target, command_id)

        def health(self) -> Health:
            return Health(ready=self.closed, boot_id="1", fault="" if self.closed else "door open")

    cell = Door(PAPER)

    def operator(hold: Hold) -> Answer | None:
        if "door open" not in hold.reason:
            return nobody(hold)
        cell.closed, cell.at = True, 1
        return None

    with pytest.raises(HeldError, match=r"\bobject 1\b.*\bexpected at object 0\b"):
        begin(tmp_path, cell, operator)
    assert sorts(cell) == []


def test_a_belt_that_stands_elsewhere_holds_the_run_before_anything_is_dropped(tmp_path: Path) -> None:
    cell = Controller(PAPER, at=1)
    with pytest.raises(HeldError, match=r"\bobject 1\b.*\bexpected at object 0\b") as held:
        begin(tmp_path, cell)
    assert cell.acts == []
    assert [(way.home, way.answer) for way in held.value.hold.ways] == [
        (0, None),
        (None, Answer.PASSED),
        (NUMBER, None),
    ]
    report = go_on(tmp_path, cell, lambda _hold: Answer.PASSED)
    assert (report.passed, [d.object for d in report.decisions]) == ((0,), [1])


def test_an_advance_that_says_done_elsewhere_is_not_believed(tmp_path: Path) -> None:
    class Slipping(Controller):
        def _act(self, name: str, target: int, command_id: str) -> None:
            super()._act(name, target, command_id)
            self.at += int(name == "advance" and target == 1)

    cell = Slipping(PAPER)
    with pytest.raises(HeldError, match=r"\bobject 2\b.*\bexpected at object 1\b"):
        begin(tmp_path, cell)
    assert len(sorts(cell)) == 1
    report = go_on(tmp_path, cell, lambda _hold: Answer.PASSED)
    assert (report.passed, [d.object for d in report.decisions]) == ((1,), [0])


def test_a_run_begins_where_the_belt_stands(tmp_path: Path) -> None:
    cell = Controller(PAPER, at=7)
    report = begin(tmp_path, cell, first=7)
    assert [decision.object for decision in report.decisions] == [7, 8]
    assert [target for name, target in cell.acts if name == "advance"] == [8, 9]
    assert report == go_on(tmp_path, cell), "what is done stays done"


@pytest.mark.parametrize("call", range(0, 30, 3))
def test_a_network_that_comes_back_needs_nobody(tmp_path: Path, call: int) -> None:
    class Cut(Controller):
        def reach(self, what: str) -> None:
            if len(self.asked) == call:
                self.unreachable = 3
            super().reach(what)

    report = begin(tmp_path, Cut(PAPER))
    assert [decision.object for decision in report.decisions] == [0, 1]
    assert [entry.data["state"] for entry in entries(tmp_path, "state")] == ["Execute", "Complete"]


def test_a_network_that_stays_away_holds_the_run_until_it_is_back(tmp_path: Path) -> None:
    cell = Controller(PAPER, unreachable=1000)
    with pytest.raises(HeldError, match=r"\bnetwork is down\b") as held:
        begin(tmp_path, cell)
    assert (held.value.hold.answers, held.value.hold.person) == ((), False)
    cell.unreachable = 0
    assert len(go_on(tmp_path, cell).decisions) == 2


def test_an_interrupt_that_a_library_swallows_ends_the_run_all_the_same(tmp_path: Path) -> None:
    with Interrupts() as interrupts:

        class Swallowing(Controller):
            def _act(self, name: str, target: int, command_id: str) -> None:
                super()._act(name, target, command_id)
                if len(self.acts) == 4:
                    with pytest.raises(KeyboardInterrupt):  # as a callback in C does
                        signal.raise_signal(signal.SIGTERM)

        with pytest.raises(Interrupted), Journal(tmp_path / "journal.sqlite") as journal:
            sort_objects(
                *(Swallowing(PAPER), scripted(certain()), LookOnce(), PAPER, journal),
                objects=9,
                check=interrupts.check,
            )
    assert len(entries(tmp_path, "intent")) == 4
    assert entries(tmp_path, "end")


def test_ids_of_attempts() -> None:
    command = Command("5e-sort-3", SortInto(2), boot_id="a")
    assert [command.again("b").id, command.again("b").again("c").id] == ["5e-sort-3.2", "5e-sort-3.3"]


def test_the_documented_table_is_the_codes_own() -> None:
    rows = re.findall(r"^\| ([a-z ]+?) +\| (.+) \| (.+) \| (.+) \|$", RECOVERY.read_text(), re.MULTILINE)
    said = {
        (command, Outcome(outcome)): Step(step)
        for outcome, *steps in rows
        if outcome in {each.value for each in Outcome}
        for command, step in zip((MoveTo, AdvanceTo, SortInto), steps, strict=True)
    }
    assert said == STEPS
    assert {outcome for _, outcome in STEPS} == set(Outcome)
