"""What is wrong with a cell file."""

from collections.abc import Callable, Iterable, Sequence

from beltsort.errors import CellError
from beltsort.util.problems import Problem, listed


class CellFileError(CellError):
    """A cell file that cannot be used, with all that is wrong with it.

    Parameters
    ----------
    problems
        At least one.
    """

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__(listed(problems))
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
