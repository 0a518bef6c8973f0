"""What a run does about requests to hold, to continue and to stop it, between two of its steps."""

import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from beltsort.sorting.entries import AnyContent, Requested, State, StateChanged
from beltsort.sorting.journal import Entry
from beltsort.sorting.requests import Request, drop_request, read_request

REQUEST_INTERVAL = 0.2
"""Time between two looks for the request to continue a run that is held by one, seconds."""

Check = Callable[[], None]
"""Called before each step of a run; an exception that it raises ends the run."""


def nothing() -> None:
    """Check nothing."""


class Heeding:
    """Heeds requests.

    Parameters
    ----------
    folder
        Folder in which requests are left; None if the run takes none.
    record
        Writes an entry and applies it to the run's state.
    check
        Called while the run is held.
    pause
        Lets `REQUEST_INTERVAL` pass.
    before
        Called before the run is held or stopped.
    """

    def __init__(
        self,
        folder: Path | None,
        record: Callable[[AnyContent], Entry],
        check: Check,
        *,
        pause: Callable[[float], None] = time.sleep,
        before: Callable[[], None] = nothing,
    ) -> None:
        self._folder, self._record, self._check = folder, record, check
        self._pause, self._before = pause, before

    def __call__(self) -> Request | None:
        """Journal a request to hold or to stop; wait while held; return the request to stop, if there is one.

        Only a hold outlasts the process: a request to stop is dropped once it is journalled, so that the run
        can be resumed.
        """
        request = None if self._folder is None else read_request(self._folder)
        if self._folder is None or request is None or request.action == "continue":
            return None
        self._record(Requested(**asdict(request)))
        self._before()
        if request.action == "hold":
            request = self._wait_while_held(self._folder, request)
            self._record(Requested(**asdict(request)))
        if request.action == "stop":
            drop_request(self._folder)
            return request
        self._record(StateChanged(State.EXECUTE, f"{request.by} asked to continue"))
        return None

    def _wait_while_held(self, folder: Path, hold: Request) -> Request:
        """Wait until a person asks to continue or to stop, and return that request."""
        self._record(StateChanged(State.HELD, f"{hold.by} asked to hold"))
        request = hold
        while request.action == "hold":
            self._pause(REQUEST_INTERVAL)
            self._check()
            request = read_request(folder) or hold  # nothing but a request ends a hold
        return request
