"""The bins of a cell, with their names and the sorter's numbers."""

from dataclasses import dataclass

from beltsort.cell.protocols import Cell, NumbersBins

REJECT = "reject"
"""Name of the bin for undecided objects."""


@dataclass(frozen=True)
class Bin:
    """A bin.

    Attributes
    ----------
    name
        The class whose objects it contains, or `REJECT`.
    number
        The sorter's number of it.
    """

    name: str
    number: int

    def __str__(self) -> str:
        """Return name and number in words."""
        return f'bin "{self.name}" ({self.number})'


def bin_of(cell: Cell, label: int) -> Bin:
    """Return the bin of a class, or of the cell's `reject_bin`.

    If the sorter has no numbers of its own, the number is the label.
    """
    names = dict(enumerate(cell.classes))
    numbers = dict(enumerate(cell.bin_numbers if isinstance(cell, NumbersBins) else ()))
    return Bin(names.get(label, REJECT), numbers.get(label, label))
