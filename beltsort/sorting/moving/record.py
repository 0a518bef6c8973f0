"""Writing an entry and applying it to the state: the only way in which a run's state changes."""

import logging
from collections.abc import Callable
from typing import TypeVar

from beltsort.cell import CommandError, EmergencyStopError
from beltsort.sorting.entries import AnyContent
from beltsort.sorting.holds import HeldError, Hold
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.moving.state import MovingState

log = logging.getLogger(__name__)

Result = TypeVar("Result")


class MovingRecord:
    """A journal, and the state of the run after its entries.

    Parameters
    ----------
    journal
        The open journal.
    state
        The state after its last entry.
    """

    def __init__(self, journal: Journal, state: MovingState) -> None:
        self.journal, self.state = journal, state

    def __call__(self, content: AnyContent) -> Entry:
        """Write an entry, apply it to the state, and return it."""
        entry = self.journal.append(content)
        self.state.apply(content)
        self.journal.object = self.state.settled
        if self.journal.full:
            self.journal.rotate(self.state.snapshot())
        return entry


class Patience:
    """Asks devices again that cannot be reached.

    Parameters
    ----------
    delays
        Seconds before each further attempt; after the last one the run is held.
    wait
        Lets time pass.
    check
        Called before each further attempt.
    """

    def __init__(
        self, delays: tuple[float, ...], wait: Callable[[float], None], check: Callable[[], None]
    ) -> None:
        self._delays, self._wait, self._check = delays, wait, check

    def __call__(self, question: Callable[[], Result]) -> Result:
        """Return the answer to a question that may be asked again.

        Raises
        ------
        EmergencyStopError
            If the emergency stop is pressed.
        HeldError
            If the device could not be asked after the last delay.
        """
        for delay in self._delays:
            try:
                return question()
            except EmergencyStopError:
                raise
            except CommandError as failure:
                log.warning("again in %g s: %s", delay, failure)
            self._wait(delay)
            self._check()
        try:
            return question()
        except EmergencyStopError:
            raise
        except CommandError as failure:
            raise HeldError(Hold(None, str(failure))) from failure
