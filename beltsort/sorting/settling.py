"""Answers that a person gives to a run's question from outside its process."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from beltsort._core import ArgumentError
from beltsort.cell.commands import SortInto
from beltsort.errors import InUseError
from beltsort.sorting.entries import Answered, Ended, ObjectsPassed, Resumed, Settled, Started, StateChanged
from beltsort.sorting.holds import Answer, Reply, Way
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.journal_queries import entries_since
from beltsort.sorting.locks import locked
from beltsort.sorting.moving.entries import MovingResumed, MovingStarted
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import progress_in
from beltsort.sorting.requests import signature, takes_requests, write_reply
from beltsort.sorting.runs import LOCK


@dataclass(frozen=True)
class Question:
    """Why a run is held, and how it can be continued.

    Attributes
    ----------
    entry
        Number of the journal entry that asks.
    ways
        The ways to continue.
    settled
        The answer that has been given and waits until it is used; None if there is none.
    """

    entry: int
    ways: tuple[Way, ...]
    settled: Answer | None = None

    @property
    def answers(self) -> tuple[Answer, ...]:
        """The possible answers."""
        return tuple(way.answer for way in self.ways if way.answer is not None)


TELLING = (
    *(StateChanged.kind, Started.kind, Resumed.kind, Ended.kind),
    *(Settled.kind, Answered.kind, ObjectsPassed.kind),
    *(MovingStarted.kind, MovingResumed.kind),
)
"""Kinds of entries that tell the state of a run, and whether it has an open question."""


def telling_entries(path: Path) -> Iterator[Entry]:
    """Yield the entries of a journal that tell the state of the run, from its last change of state on."""
    return entries_since(path, StateChanged.kind, TELLING)


def open_question(entries: Iterable[Entry]) -> Question | None:
    """Return the question at which a run is held, from its entries; None if there is none."""
    found: Question | None = None
    for entry in entries:
        found = question_after(found, entry)
    return found


def question_after(found: Question | None, entry: Entry) -> Question | None:
    """Return the question that is open after an entry, given the one before it."""
    match entry.content:
        case StateChanged(ways=ways):
            return None if ways is None else Question(entry.number, tuple(ways))
        case Started() | Resumed() | Answered() | ObjectsPassed() | MovingStarted() | MovingResumed():
            return None
        case Settled(answer) if found is not None:
            return Question(found.entry, found.ways, answer)
    return found


def may_answer(answer: Answer, progress: Progress) -> bool:
    """Return whether the first question of a run that is resumed can have this answer."""
    if answer is Answer.PASSED:
        return True
    pending = progress.pending
    sorting = pending is not None and isinstance(pending.act, SortInto)
    return sorting and progress.known_outcome is None


def settle(folder: Path, answer: Answer, through: str, question: int | None = None) -> Reply:
    """Answer the question of a run, which is used when the run is resumed, or at once if it waits.

    The device is asked first when the run is resumed, as with `beltsort run --settle`; the answer counts
    where it does not know. An answer replaces an earlier one that has not been used.

    Parameters
    ----------
    folder
        The run's.
    answer
        The answer.
    through
        Names the program with which it is given.
    question
        Number of the journal entry that asks, if the person has seen it; None: whichever is open.

    Raises
    ------
    ArgumentError
        If the run has no question with this answer.
    InUseError
        If the run is under way and takes no answers from outside.
    JournalError
        If the journal cannot be read or written.
    OSError
        If the answer to a run that waits cannot be written.
    """
    reply = Reply(answer, *signature(through))
    try:
        with locked(f"the run {folder}", folder / LOCK):
            _checked(folder, answer, question)
            with Journal(folder / JOURNAL, resume=True) as journal:
                journal.append(Settled(reply.answer, reply.by, reply.at))
    except InUseError as reason:
        asked = _checked(folder, answer, question)
        if asked is None:
            raise ArgumentError(
                f"the answer is {answer}, but the run is under way and waits for none: leave it out"
            ) from reason
        if not takes_requests(folder):
            raise InUseError(
                "the run waits for the answer at its terminal and takes none from elsewhere: answer there, "
                "or start it with --allow-hold"
            ) from reason
        write_reply(folder, reply, asked.entry)
    return reply


def _checked(folder: Path, answer: Answer, question: int | None) -> Question | None:
    """Return the open question after checking that it may have an answer; None if none was asked yet."""
    journal = folder / JOURNAL
    asked = open_question(telling_entries(journal))
    if question is not None and (asked is None or asked.entry != question):
        raise ArgumentError("the question is no longer open: look at the run again")
    known = may_answer(answer, progress_in(journal)) if asked is None else answer in asked.answers
    if not known:
        answers = ", ".join(asked.answers) if asked is not None and asked.answers else "no answer"
        raise ArgumentError(
            f"the answer is {answer}, but the run waits for {answers} (it may have been given already): see "
            "`beltsort status`"
        )
    return asked
