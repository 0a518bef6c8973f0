"""Answers from outside the process of a run: recorded, used once, and refused where nothing asks for them."""

import os
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from beltsort import ArgumentError
from beltsort.cell import CommandError
from beltsort.cli.operator import CommandLineOperator
from beltsort.errors import InUseError
from beltsort.sorting.entries import Settled
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.holds import Answer, HeldError, Reply
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.locks import locked
from beltsort.sorting.loop import resume_sorting
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import progress_in
from beltsort.sorting.requests import ANSWER, read_reply, takes_requests, taking_requests, write_reply
from beltsort.sorting.runs import LOCK
from beltsort.sorting.settling import open_question, settle
from beltsort.sorting.status import Condition, status_of
from tests.sorting.scripted_cell import LookOnce, scripted
from tests.sorting.test_commander import certain
from tests.sorting.test_recovery import PAPER, RULES, Controller, begin, go_on, sorts
from tests.waiting import wait_until


def held(folder: Path, **breaks: Any) -> Controller:
    """Return the cell of a run that has ended with a question about a sort."""
    cell = Controller(PAPER, breaks={"sort": [CommandError]}, **breaks)
    with pytest.raises(HeldError):
        begin(folder, cell)
    return cell


def resumed(folder: Path, cell: Controller, settled: str | None = None) -> None:
    go_on(folder, cell, CommandLineOperator(settled, progress_in(folder / JOURNAL)))


@pytest.mark.parametrize("answer", [Answer.DONE, Answer.NOT_DONE])
def test_an_answer_waits_in_the_journal_until_the_run_is_resumed(tmp_path: Path, answer: Answer) -> None:
    cell = held(tmp_path)
    question = status_of(tmp_path).question
    assert question is not None
    assert question.answers == (Answer.DONE, Answer.NOT_DONE)
    reply = settle(tmp_path, answer, "beltsort settle")
    assert "(beltsort settle)" in reply.by
    status = status_of(tmp_path)
    assert (status.condition, status.question and status.question.settled) == (Condition.HELD, answer)
    kept = read_journal(tmp_path / JOURNAL)[-1]
    assert kept.content == Settled(answer, reply.by, reply.at)
    assert f"{answer.value}, says {reply.by}" in (EntryFormatter().format(kept) or "")
    resumed(tmp_path, cell)
    assert len(sorts(cell)) == (1 if answer is Answer.DONE else 2)
    assert status_of(tmp_path).question is None
    assert progress_in(tmp_path / JOURNAL).settled is None


def test_the_last_answer_counts_and_the_option_before_it(tmp_path: Path) -> None:
    cell = held(tmp_path)
    settle(tmp_path, Answer.NOT_DONE, "test")
    settle(tmp_path, Answer.NOT_DONE, "test")
    resumed(tmp_path, cell, "done")
    assert len(sorts(cell)) == 1


def test_the_device_is_asked_first(tmp_path: Path) -> None:
    cell = held(tmp_path)
    settle(tmp_path, Answer.DONE, "test")
    cell.memory.clear()  # and now it says that it did nothing
    resumed(tmp_path, cell)
    assert len(sorts(cell)) == 2
    assert progress_in(tmp_path / JOURNAL).settled is None


def test_an_answer_outlives_a_hold_for_another_reason_and_a_new_journal_file(tmp_path: Path) -> None:
    cell = held(tmp_path)
    settle(tmp_path, Answer.NOT_DONE, "test")
    cell.unreachable = 99
    with pytest.raises(HeldError, match="network"):
        resumed(tmp_path, cell)
    cell.unreachable = 0
    progress = progress_in(tmp_path / JOURNAL)
    assert progress.settled is Answer.NOT_DONE
    assert Progress.after([Entry(1, "", 0, progress.snapshot())]).settled is Answer.NOT_DONE
    resumed(tmp_path, cell)
    assert len(sorts(cell)) == 2


def test_objects_that_passed(tmp_path: Path) -> None:
    cell = Controller(PAPER)
    cell.at = 1
    with pytest.raises(HeldError, match="object 1"):
        begin(tmp_path, cell)
    with pytest.raises(ArgumentError, match=r"\bdone, but the run waits for passed\b"):
        settle(tmp_path, Answer.DONE, "test")
    settle(tmp_path, Answer.PASSED, "test")
    resumed(tmp_path, cell)
    assert progress_in(tmp_path / JOURNAL).passed == [0]


def test_wrong_answers(tmp_path: Path) -> None:
    cell = held(tmp_path)
    before = read_journal(tmp_path / JOURNAL)
    with pytest.raises(ArgumentError, match=r"\bpassed, but the run waits for done, not-done\b"):
        settle(tmp_path, Answer.PASSED, "test")
    with pytest.raises(ArgumentError, match=r"\bno longer open\b"):
        settle(tmp_path, Answer.DONE, "test", question=3)
    assert read_journal(tmp_path / JOURNAL) == before
    asked = open_question(before)
    assert asked is not None
    settle(tmp_path, Answer.DONE, "test", question=asked.entry)
    resumed(tmp_path, cell)
    with pytest.raises(ArgumentError, match=r"\bno answer\b"):
        settle(tmp_path, Answer.DONE, "test")


def test_a_run_under_way(tmp_path: Path) -> None:
    held(tmp_path)
    with locked("the run", tmp_path / LOCK):
        with pytest.raises(InUseError, match=r"\bat its terminal\b"):
            settle(tmp_path, Answer.DONE, "test")
        with taking_requests(tmp_path):
            reply = settle(tmp_path, Answer.DONE, "test")
            question = status_of(tmp_path).question
            assert question is not None
            assert read_reply(tmp_path, question.entry) == reply
            assert read_reply(tmp_path, question.entry + 1) is None
            assert read_reply(tmp_path, None) is None
    with Journal(tmp_path / JOURNAL, resume=True) as journal:
        journal.append(Settled(Answer.DONE, "a", "b"))


def test_a_run_that_ends_with_a_question_keeps_its_token(tmp_path: Path) -> None:
    cell = Controller(PAPER, breaks={"sort": [CommandError]})
    with pytest.raises(HeldError), taking_requests(tmp_path):
        begin(tmp_path, cell)
    assert takes_requests(tmp_path)
    with taking_requests(tmp_path):
        settle(tmp_path, Answer.DONE, "test")
        resumed(tmp_path, cell)
    assert not takes_requests(tmp_path)


class Terminal:
    """A terminal at which nobody types, unless `type` is called."""

    def __init__(self) -> None:
        self._end, self._typed = os.pipe()
        self._lines = os.fdopen(self._end)

    def isatty(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._end

    def type(self, line: str) -> None:
        os.write(self._typed, f"{line}\n".encode())

    def readline(self) -> str:
        return self._lines.readline()

    def write(self, text: str) -> int:
        return len(text)

    def flush(self) -> None:
        pass


@pytest.mark.parametrize("typed", [False, True])
def test_a_run_that_waits_at_its_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, typed: bool
) -> None:
    cell, terminal = held(tmp_path), Terminal()
    monkeypatch.setattr(sys, "stdin", terminal)
    monkeypatch.setattr(sys, "stderr", terminal)
    stale = status_of(tmp_path).question
    assert stale is not None

    def answer() -> None:
        wait_until(lambda: asks_anew(tmp_path, stale.entry), "the question")
        if typed:
            terminal.type("done")
        else:
            settle(tmp_path, Answer.DONE, "beltsort settle")

    with locked("the run", tmp_path / LOCK), taking_requests(tmp_path):
        write_reply(tmp_path, Reply(Answer.NOT_DONE, "late", "before"), stale.entry)
        threading.Thread(target=answer).start()
        operator = CommandLineOperator(None, progress_in(tmp_path / JOURNAL), tmp_path)
        with Journal(tmp_path / JOURNAL, resume=True) as journal:
            resume_sorting(*(cell, scripted(certain()), LookOnce(), journal), rules=RULES, operator=operator)
    assert len(sorts(cell)) == 1
    said = [entry.content for entry in read_journal(tmp_path / JOURNAL) if entry.kind == "settled"]
    assert len(said) == (0 if typed else 1)
    assert (tmp_path / ANSWER).exists()  # dropped when the run starts again


def asks_anew(folder: Path, earlier: int) -> bool:
    question = status_of(folder).question
    return question is not None and question.entry > earlier
