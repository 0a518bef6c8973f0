"""What is read from a cloud file, and why one cannot be read."""

from dataclasses import dataclass

from beltsort.geometry import Points


class UnreadableError(Exception):
    """The content of a file is not understood.

    Parameters
    ----------
    problem
        What was read, and what was expected.
    line
        Number of the line, from 1, in a text file.
    remedy
        What to do; default: to write the file again.
    """

    def __init__(self, problem: str, *, line: int | None = None, remedy: str | None = None) -> None:
        super().__init__(problem)
        self.problem, self.line, self.remedy = problem, line, remedy

    def message(self, file: object, remedy: str) -> str:
        """Return the whole message about `file`; `remedy` is used unless the problem has one of its own."""
        where = f"{file}" if self.line is None else f"{file}, line {self.line}"
        return f"cannot read {where}: {self.problem}; {self.remedy or remedy}"


@dataclass(frozen=True, eq=False)
class Content:
    """The content of a cloud file.

    Attributes
    ----------
    points
        Shape (n, 3), in the file's unit and frame.
    camera
        The camera's position in the frame of the points, shape (3,), if the file names one.
    faces
        Number of faces in the file, which are not read.
    notes
        What else is in the file and not used, for a warning.
    """

    points: Points
    camera: Points | None = None
    faces: int = 0
    notes: tuple[str, ...] = ()


def expect(found: int, promised: int, what: str) -> None:
    """Raise `UnreadableError` if a file holds less than its header declares."""
    if found < promised:
        raise UnreadableError(f"{found} {what} where the header promises {promised}")


def left_over(rest: bytes, what: str) -> tuple[str, ...]:
    """Return a note about data behind what a header declares; blanks and zero bytes are padding."""
    padding = b"\0 \t\r\n"
    return (f"{len(rest)} bytes behind {what} are not read",) if rest.strip(padding) else ()
