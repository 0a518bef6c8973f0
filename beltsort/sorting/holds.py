"""Held runs: the question to the operator, and the possible answers."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from beltsort.cell.bins import Bin
from beltsort.cell.protocols import NOWHERE
from beltsort.errors import CellError
from beltsort.sorting.command import Command


class Answer(StrEnum):
    """An operator's answer about a held run."""

    DONE = "done"
    """The command was done: the object is in the bin."""
    NOT_DONE = "not-done"
    """The command was not done: the object is still at the belt end."""
    PASSED = "passed"
    """Objects passed the belt end unsorted; the run continues at the belt's position."""


@dataclass(frozen=True)
class Reply:
    """An answer that was given from outside the process of the run.

    Attributes
    ----------
    answer
        The answer.
    by
        Who gave it.
    at
        When, UTC, ISO 8601.
    """

    answer: Answer
    by: str
    at: str


NUMBER = "NUMBER"
"""Placeholder for the number of the object that the operator sees at the belt end."""


@dataclass(frozen=True)
class Way:
    """One way to continue a held run.

    Attributes
    ----------
    when
        The condition under which this is the right one.
    answer
        The operator's answer; None if the run can be resumed without one.
    home
        The object number with which the belt must be homed first, `NUMBER` for the one that the operator
        sees; None if it need not be homed.
    """

    when: str
    answer: Answer | None = None
    home: int | str | None = None

    def __str__(self) -> str:
        """Return condition and commands in words."""
        homing = "" if self.home is None else f"home {self.home} and "
        return f"{self.when}: {homing}resume" + (
            "" if self.answer is None else f" --settle {self.answer.value}"
        )


ONCE_FIXED = (Way("once that is fixed"),)
FURTHER = Way("if another one further on is", home=NUMBER)
"""The run then asks about the objects in between."""


@dataclass(frozen=True)
class Hold:
    """Why a run is held, and how it can be continued.

    Attributes
    ----------
    command
        The command at which it is held; None between two commands.
    reason
        What happened, and what to check.
    ways
        The ways to continue, by condition.
    person
        Whether an operator must answer or check the cell, so that resuming repeatedly does not help.
    object
        Number of the object at the belt end, as far as the run knows.
    question
        Number of the journal entry that asks; None before it is asked.
    """

    command: Command | None
    reason: str
    ways: tuple[Way, ...] = ONCE_FIXED
    person: bool = False
    object: int | None = None
    question: int | None = None

    @property
    def answers(self) -> tuple[Answer, ...]:
        """The possible answers."""
        return tuple(way.answer for way in self.ways if way.answer is not None)

    def __str__(self) -> str:
        """Return reason and ways in one line."""
        where = "" if self.command is None else f" at {self.command.act}"
        return f"held{where}: {self.reason}. {'; '.join(map(str, self.ways))}"


class HeldError(CellError):
    """The run is held until an operator has checked the cell.

    Attributes
    ----------
    hold
        The reason, and the ways to continue.
    """

    def __init__(self, hold: Hold) -> None:
        self.hold = hold
        super().__init__(str(hold))


Operator = Callable[[Hold], Answer | Reply | None]
"""Returns the operator's answer, one of the hold's, or None for a way without an answer."""


def nobody(hold: Hold) -> Answer | None:
    """Raise the hold as an error: there is no operator to ask, and the run ends as held."""
    raise HeldError(hold)


def in_doubt(command: Command, index: int, into: Bin, broken_off: bool, why: str) -> Hold:
    """Return the hold for a sort of object `index` whose outcome the device does not know."""
    known = "was broken off" if broken_off else "may or may not have been done"
    ways = (
        Way(f"if object {index} is in {into}", Answer.DONE),
        Way("if it is still at the belt end (put it back there if it lies elsewhere)", Answer.NOT_DONE),
    )
    reason = f"the sort into {into} {known} ({why}), and the device cannot tell more; look"
    return Hold(command, reason, ways, person=True)


def at_the_end(expected: range) -> list[Way]:
    """Return the ways to home the belt, one for each object that may be at its end."""
    return [Way(f"if object {i} is at the belt end", home=i) for i in expected]


def belt_elsewhere(position: int, expected: range, command: Command | None, needs_home: bool) -> Hold:
    """Return the hold for a belt that is not at an expected position."""
    stands = "at no object" if position == NOWHERE else f"at object {position}"
    last = expected[-1]
    ways = at_the_end(expected)
    if position > last:
        when = f"if object {position} is, take care of those that went past unsorted"
        ways.append(Way(when, Answer.PASSED, home=position if needs_home else None))
    ways.append(FURTHER)
    reason = (
        f"the belt says that it stands {stands}, expected at object {last}; "
        "look which object is at the belt end"
    )
    return Hold(command, reason, tuple(ways), person=True)
