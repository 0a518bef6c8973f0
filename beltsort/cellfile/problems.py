"""Problems of a cell file, and the error that reports them."""

from collections.abc import Callable, Iterable, Sequence

from beltsort.errors import CellError
from beltsort.util.problems import Problem, listed


class CellFileError(CellError):
    """A cell file is invalid. The message has a line for each problem.

    Parameters
    ----------
    problems
        The problems, at least one.
    """

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__(listed(problems))
        self.problems = tuple(problems)

    @classmethod
    def of(cls, where: str, what: str) -> "CellFileError":
        """Return an error with one problem."""
        return cls([Problem(where, what)])

    def below(self, place: Callable[[str], str]) -> "CellFileError":
        """Return the error with each `where` prefixed by the table that `place` returns for it."""
        return CellFileError(
            [Problem(f"{place(where)}.{where}".rstrip("."), what) for where, what in self.problems]
        )


def raise_all(errors: Iterable[CellFileError]) -> None:
    """Raise one error with the distinct problems of all errors, if there are any."""
    if problems := {problem: None for error in errors for problem in error.problems}:
        raise CellFileError(list(problems))
