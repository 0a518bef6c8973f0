"""The bins of a cell, by name and by the sorter's own number."""

from dataclasses import dataclass

from beltsort.cell.protocols import Cell, NumbersBins

REJECT = "reject"
"""Name of the bin for undecided objects."""


@dataclass(frozen=True)
class Bin:
    """Where objects are put.

    Attributes
    ----------
    name
        The class that belongs there, or `REJECT`.
    number
        What the sorter is sent.
    """

    name: str
    number: int

    def __str__(self) -> str:
        """Return it in words."""
        return f'bin "{self.name}" ({self.number})'


def bin_of(cell: Cell, label: int) -> Bin:
    """Return the bin of a class, or of the cell's `reject_bin`.

    A sorter without numbers of its own is sent the label.
    """
    names = dict(enumerate(cell.classes))
    numbers = dict(enumerate(cell.bin_numbers if isinstance(cell, NumbersBins) else ()))
    return Bin(names.get(label, REJECT), numbers.get(label, label))
