"""What a person is asked when a run is held, and what may be answered."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from beltsort.cell.bins import Bin
from beltsort.cell.protocols import NOWHERE
from beltsort.errors import CellError
from beltsort.sorting.command import Command


class Answer(Enum):
    """What a person says of a run that is held."""

    DONE = "done"
    """The command in question was done: the object is in the bin."""
    NOT_DONE = "not-done"
    """It was not: the object is still at the belt end."""
    PASSED = "passed"
    """The belt went past objects, which were not sorted; the run is to go on where it stands."""


NUMBER = "NUMBER"
"""Stands for the number of an object that a person sees."""


@dataclass(frozen=True)
class Way:
    """One way out of a hold.

    Attributes
    ----------
    when
        What must be true.
    answer
        What is then to be answered; None: the run can be resumed without an answer.
    home
        The object number with which the belt is then to be homed before, `NUMBER` if that is what a person
        sees; None if it need not be.
    """

    when: str
    answer: Answer | None = None
    home: int | str | None = None

    def __str__(self) -> str:
        """Return it in a few words."""
        homing = "" if self.home is None else f"home {self.home} and "
        return f"{self.when}: {homing}resume" + (
            "" if self.answer is None else f" --settle {self.answer.value}"
        )


MENDED = (Way("once that is mended"),)
FURTHER = Way("if another one further on is", home=NUMBER)
"""The run then asks about those between."""


@dataclass(frozen=True)
class Hold:
    """Why a run is held, and what a person can do about it.

    Attributes
    ----------
    command
        The command at which it is held; None between two commands.
    reason
        What happened, and what to look at.
    ways
        How to go on, by what is true.
    person
        Whether a person must decide or see to the cell, so that resuming again and again does not help.
    object
        Number of the object that the run has at the belt end.
    """

    command: Command | None
    reason: str
    ways: tuple[Way, ...] = MENDED
    person: bool = False
    object: int | None = None

    @property
    def answers(self) -> tuple[Answer, ...]:
        """What may be answered."""
        return tuple(way.answer for way in self.ways if way.answer is not None)

    def __str__(self) -> str:
        """Return all of it in one line."""
        where = "" if self.command is None else f" at {self.command.act}"
        return f"held{where}: {self.reason}. {'; '.join(map(str, self.ways))}"


class HeldError(CellError):
    """The run is held until a person has seen to the cell.

    Attributes
    ----------
    hold
        Why.
    """

    def __init__(self, hold: Hold) -> None:
        self.hold = hold
        super().__init__(str(hold))


Operator = Callable[[Hold], Answer | None]
"""Says what a person has found: one of the hold's answers, or None where a way without one was gone."""


def nobody(hold: Hold) -> Answer | None:
    """Answer no question: the run ends as held."""
    raise HeldError(hold)


def in_doubt(command: Command, index: int, into: Bin, broken_off: bool, why: str) -> Hold:
    """Return the question what became of the sort of object `index` into a bin, which no device can tell."""
    known = "was broken off" if broken_off else "may or may not have been done"
    ways = (
        Way(f"if object {index} is in {into}", Answer.DONE),
        Way("if it is still at the belt end (put it back there if it lies elsewhere)", Answer.NOT_DONE),
    )
    reason = f"the sort into {into} {known} ({why}), and the device cannot tell more; look"
    return Hold(command, reason, ways, person=True)


def at_the_end(expected: range) -> list[Way]:
    """Return a way for each object that may be at the belt end."""
    return [Way(f"if object {i} is at the belt end", home=i) for i in expected]


def belt_elsewhere(position: int, expected: range, command: Command | None, needs_home: bool) -> Hold:
    """Return the hold for a belt that stands elsewhere than it should."""
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
