"""Which object is where: cups at regular distances along a belt, numbered from the first.

An object's coordinate is the belt's travel when it passes the belt end (x = 0); at travel T it is at x =
coordinate - T. Place j of a belief, the exit's first, reaches from (j - 1/2) to (j + 1/2) spacings; an object
has passed the exit half a spacing beyond the belt end.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Lattice:
    """The regular places of objects on the belt.

    Attributes
    ----------
    spacing
        Distance between two objects, metres.
    origin
        Coordinate of object `first`, metres.
    first
        Number of that object; there is none before it.

    Examples
    --------
    >>> lattice = Lattice(spacing=0.2, origin=0.03, first=10)
    >>> lattice.number(0.45), round(lattice.coordinate(12), 2)
    (12, 0.43)
    >>> lattice.at_exit(travel=0.2), lattice.offset(travel=0.2, ticks_per_place=10)
    (11, 3)
    """

    spacing: float
    origin: float
    first: int

    @classmethod
    def through(cls, cups: Sequence[float], travel: float, spacing: float, first: int) -> "Lattice":
        """Return the lattice that fits measured coordinates best.

        Parameters
        ----------
        cups
            Coordinates of cups, metres, at least one.
        travel
            The belt's travel, metres.
        spacing
            Distance between two objects, metres.
        first
            Number of the object at the belt end at that travel.
        """
        turn = 2.0 * math.pi / spacing
        mean = math.atan2(
            sum(math.sin(turn * cup) for cup in cups), sum(math.cos(turn * cup) for cup in cups)
        )
        phase = mean / turn
        steps = math.floor((travel - phase - spacing / 2.0) / spacing) + 1
        return cls(spacing, phase + steps * spacing, first)

    def number(self, coordinate: float) -> int:
        """Return the number of the object nearest to a coordinate."""
        return self.first + round((coordinate - self.origin) / self.spacing)

    def coordinate(self, number: int) -> float:
        """Return where an object stands if it is where it should be, metres."""
        return self.origin + (number - self.first) * self.spacing

    def mark(self, number: int) -> int:
        """Return the number of an object for the belt's controller, at least 0.

        It counts half spacings along the belt since the controller's start. So no two objects have the same,
        also if runs follow each other, whose lattices differ by less than a quarter of a spacing.
        """
        return max(0, round(2.0 * self.origin / self.spacing) + 2 * (number - self.first))

    def at_exit(self, travel: float) -> int:
        """Return the number of the object at the belt end, that of place 0."""
        return self.first + math.floor((travel - self.origin - self.spacing / 2.0) / self.spacing) + 1

    def offset(self, travel: float, ticks_per_place: int) -> int:
        """Return the ticks since an object last passed the exit, from 0 to `ticks_per_place` - 1."""
        beyond = (travel - self.origin + self.spacing / 2.0) / self.spacing
        return min(int((beyond - math.floor(beyond)) * ticks_per_place), ticks_per_place - 1)
