"""The offset of a device's clock from the cell's, bounded by round trips."""

from dataclasses import dataclass
from typing import Self

DRIFT = 200e-6
"""Most that two clocks may drift apart, seconds per second."""


@dataclass(frozen=True)
class ClockBounds:
    """Bounds of what must be added to a time of the device's clock to get the cell's time.

    A device reads its clock at `stamp`, some time between the request for it (`sent`) and the arrival of the
    reply (`received`), so that the offset of the clocks lies in [sent - stamp, received - stamp], widened by
    `DRIFT` times the duration of the trip. The bounds of several round trips are intersected, the earlier
    ones widened by `DRIFT` times their age.

    Attributes
    ----------
    least, most
        Bounds of the offset, seconds.
    at
        Time at which they held, seconds on the cell's clock.

    References
    ----------
    F. Cristian, "Probabilistic clock synchronization", Distributed Computing 3 (1989).

    Examples
    --------
    >>> bounds = ClockBounds.of(sent=10.0, received=10.5, stamp=2.25)
    >>> round(bounds.offset, 3), round(bounds.error, 3)
    (8.0, 0.25)
    >>> round(bounds.narrowed(ClockBounds.of(sent=20.25, received=20.5, stamp=12.375)).error, 3)
    0.125
    """

    least: float
    most: float
    at: float

    @classmethod
    def of(cls, sent: float, received: float, stamp: float) -> Self:
        """Return the bounds from one round trip.

        Parameters
        ----------
        sent, received
            When the request was sent and when the reply had arrived, seconds on the cell's clock.
        stamp
            The reply's, seconds on the device's clock.
        """
        drift = DRIFT * (received - sent)
        return cls(sent - stamp - drift, received - stamp + drift, received)

    def narrowed(self, later: Self) -> Self:
        """Return the bounds after a later round trip; these alone if they contradict the earlier ones."""
        drift = DRIFT * abs(later.at - self.at)
        least, most = max(self.least - drift, later.least), min(self.most + drift, later.most)
        return type(self)(least, most, later.at) if least <= most else later

    @property
    def offset(self) -> float:
        """The middle of the bounds, seconds."""
        return (self.least + self.most) / 2.0

    @property
    def error(self) -> float:
        """Most that `offset` may be wrong by, seconds."""
        return (self.most - self.least) / 2.0
