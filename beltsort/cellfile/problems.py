"""What is wrong with a cell file."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from beltsort.errors import CellError


class Problem(NamedTuple):
    """One thing that is wrong.

    Attributes
    ----------
    where
        Table and key, `belt.spacing`; empty for the file as a whole.
    what
        What was found, what is expected, what to do.
    """

    where: str
    what: str


class CellFileError(CellError):
    """A cell file that cannot be used, with all that is wrong with it.

    Parameters
    ----------
    problems
        At least one.
    """

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__("\n".join(f"{where}: {what}" if where else what for where, what in problems))
        self.problems = tuple(problems)

    @classmethod
    def of(cls, where: str, what: str) -> "CellFileError":
        """Return the error of one problem."""
        return cls([Problem(where, what)])

    def below(self, place: Callable[[str], str]) -> "CellFileError":
        """Return the error with every `where` put below the table that `place` names for it."""
        return CellFileError(
            [Problem(f"{place(where)}.{where}".rstrip("."), what) for where, what in self.problems]
        )


def raise_all(errors: Iterable[CellFileError]) -> None:
    """Raise one error with the problems of all, each once, if there are any."""
    if problems := {problem: None for error in errors for problem in error.problems}:
        raise CellFileError(list(problems))
