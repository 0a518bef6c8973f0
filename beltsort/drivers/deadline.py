"""The time at which a timeout ends, shared by the requests that one call of a driver makes."""

import time
from math import isfinite

from beltsort.cell.commands import CommandError, Outcome


class Deadline:
    """The end of a timeout that starts now.

    Parameters
    ----------
    timeout
        Seconds.

    Attributes
    ----------
    timeout
        As given.

    Examples
    --------
    >>> Deadline(10.0).left() <= 10.0
    True
    """

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self._end = time.monotonic() + timeout

    def left(self) -> float:
        """Return the seconds that are left, 0 when it is over."""
        return max(0.0, self._end - time.monotonic())


def checked_deadline(timeout: float) -> Deadline:
    """Return the deadline of a timeout that the caller of a driver has chosen.

    Raises
    ------
    CommandError
        `NOT_DONE` if the timeout is not finite or not above 0 seconds.
    """
    if not (isfinite(timeout) and timeout > 0.0):
        raise CommandError(
            f"timeout is {timeout}, expected a finite number of seconds above 0; give one", Outcome.NOT_DONE
        )
    return Deadline(timeout)
