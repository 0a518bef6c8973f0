"""The bins of a cell, with their names and the sorter's numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

from beltsort.cell.diverting import DivertingCell
from beltsort.cell.protocols import Cell, NamesBins, NumbersBins

REJECT = "reject"
"""Name of the bin for undecided objects."""


@dataclass(frozen=True)
class Bin:
    """A bin.

    Attributes
    ----------
    name
        One of the model's bins, which are the classes unless the model names others, or `REJECT`.
    number
        The sorter's number of it.
    """

    name: str
    number: int

    def __str__(self) -> str:
        """Return name and number in words."""
        return f'bin "{self.name}" ({self.number})'


def bin_names_of(cell: Cell | DivertingCell) -> tuple[str, ...]:
    """Return the names of a cell's bins, without the reject bin; those of its classes if it names none."""
    return tuple((isinstance(cell, NamesBins) and cell.bin_names) or cell.classes)


def without_empty(names: Sequence[str], empty: str | None, known: Sequence[str]) -> list[str]:
    """Return a model's classes or bins without a last one for empty cups that a cell does not have.

    Parameters
    ----------
    names
        Names of the model's classes or bins.
    empty
        Name of the model's class for empty cups; None if there is none.
    known
        Names of the cell's classes or bins.

    Examples
    --------
    >>> without_empty(["nut", "bolt", "none"], "none", ["nut", "bolt"])
    ['nut', 'bolt']
    """
    return list(names[:-1] if names[-1] == empty and empty not in known else names)


def bin_of(cell: Cell | DivertingCell, index: int) -> Bin:
    """Return a bin of a cell by its index, or the cell's `reject_bin`.

    If the sorter has no numbers of its own, the number is the index.
    """
    names = dict(enumerate(bin_names_of(cell)))
    numbers = dict(enumerate(cell.bin_numbers if isinstance(cell, NumbersBins) else ()))
    return Bin(names.get(index, REJECT), numbers.get(index, index))
