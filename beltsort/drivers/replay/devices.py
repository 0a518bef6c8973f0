"""The devices of a recorded cell."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Self, TypeVar

import numpy as np

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome, within
from beltsort.cell.protocols import Health, Scan
from beltsort.drivers.replay.bag import Bag, cloud_of
from beltsort.drivers.replay.index import Entry, Index, read_index
from beltsort.drivers.replay.options import ReplayOptions
from beltsort.drivers.replay.poses import recorded_pose
from beltsort.drivers.ros.clouds import points_of
from beltsort.drivers.ros.ledger import Ledger
from beltsort.errors import CellError

Result = TypeVar("Result")


class Replay:
    """Arm, camera and belt of a recording.

    A move succeeds at once. A scan is the next recorded one from the viewpoint (and with the same object at
    the belt end, if the recording contains it) after the last event that was played back; scans in between
    are skipped, since time in the recording only moves forward. A run that repeats the recorded actions gets
    the recorded scans; other runs reach the end of the recording earlier.

    The first call, or `connect`, opens the bag and indexes it; scans are read one at a time.

    Parameters
    ----------
    options
        The bag and its topics.
    """

    def __init__(self, options: ReplayOptions) -> None:
        self._options = options
        self._ledger = Ledger()
        self._reader = ThreadPoolExecutor(1, "replay")  # SQLite serves only the thread that opened it
        self._opened: tuple[Bag, Index] | None = None
        self._viewpoint: str | None = None
        self._object: str | None = None
        self._next = 0
        self._clock = -np.inf

    def connect(self) -> None:
        """Open the bag and index it.

        Raises
        ------
        CellError
            If it is missing, damaged, truncated, or lacks what the options name.
        """
        self._read(TIMEOUT, self._record)

    def close(self) -> None:
        """Close the bag. A later call opens it again and continues."""

        def close() -> None:
            if self._opened is not None:
                self._opened[0].close()
                self._opened = None

        self._read(TIMEOUT, close)

    def __enter__(self) -> Self:
        """Use the replay as a context that closes the bag."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the bag."""
        self.close()

    def health(self) -> Health:
        """Return that the device is ready; raises `CellError` if the bag cannot be read."""
        self.connect()
        return Health(ready=True, boot_id=f"replay of {self._options.path}")

    def stop(self) -> None:
        """Do nothing: nothing moves."""

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command."""
        return self._ledger[command_id].outcome if command_id in self._ledger else Outcome.NOT_DONE

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Continue with scans from `viewpoint`; return the time in the recording, seconds."""
        names = self._options.viewpoints
        if not 0 <= viewpoint < len(names):
            raise CommandError(
                f"viewpoint is {viewpoint}, expected an index from 0 to {len(names) - 1} "
                f"({', '.join(names)})",
                Outcome.NOT_DONE,
            )

        def move() -> float:
            self._read(timeout, self._record)
            self._viewpoint = names[viewpoint]
            return self._clock

        return self._ledger.once("move_to", viewpoint, command_id, move)

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Continue when object `index` is at the belt end; return the time at which it arrived, seconds."""

        def advance() -> float:
            arrivals = self._read(timeout, self._record)[1].objects
            for time, name in zip(arrivals.times, arrivals.states, strict=True):
                if name == str(index) and (time >= self._clock or name == self._object):
                    self._object, self._clock = name, max(time, self._clock)
                    return self._clock
            raise CommandError(
                f"{self._options.path} does not bring object {index} to the belt end after the time "
                f"{self._clock:.3f} (it stands at object {self._object}), expected, and forward only, one of "
                f"{', '.join(str(name) for name in arrivals.states) or 'none: it records no belt'}",
                Outcome.NOT_DONE,
            )

        return self._ledger.once("advance_to", index, command_id, advance)

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return the next recorded scan from the arm's viewpoint.

        Raises
        ------
        CommandError
            If there are no more, or the scan is unusable; the next call continues after it.
        """
        if not np.isfinite(not_before):
            raise CellError(f"not_before is {not_before}, expected a time of the recording; give a number")
        return self._read(timeout, lambda: self._next_scan(not_before))

    def _read(self, timeout: float, act: Callable[[], Result]) -> Result:
        """Call a function in the bag's thread, with a timeout."""
        return within(timeout, f"reading {self._options.path}", lambda: self._reader.submit(act).result())

    def _record(self) -> tuple[Bag, Index]:
        """Return the bag and its index; open it if necessary."""
        if self._opened is None:
            bag = Bag(self._options.path)
            try:
                index = read_index(bag, self._options)
            except BaseException:
                bag.close()
                raise
            self._opened = bag, index
            if not np.isfinite(self._clock):
                self._clock, self._object = index.entries[0].stamp, index.entries[0].object
        return self._opened

    def _next_scan(self, not_before: float) -> Scan:
        entries = self._record()[1].entries
        for n in range(self._next, len(entries)):
            entry = entries[n]
            if self._fits(entry) and entry.stamp >= max(not_before, self._clock):
                self._next, self._clock = n + 1, entry.stamp
                return self._scan_at(entry)
        wanted = f"{self._viewpoint!r}" + ("" if self._object is None else f" of object {self._object}")
        there = sum(map(self._fits, entries))
        raise CommandError(
            f"{self._options.path} has no more scans from viewpoint {wanted} after the time "
            f"{max(not_before, self._clock):.3f} ({there} of {len(entries)} scans are from there), expected "
            "one more; record a longer run, or move to where it goes on",
            Outcome.NOT_DONE,
        )

    def _fits(self, entry: Entry) -> bool:
        return entry.viewpoint == self._viewpoint and entry.object == self._object

    def _scan_at(self, entry: Entry) -> Scan:
        bag, index = self._record()
        found = bag.messages({self._options.scan_topic}, entry.place.time, entry.place.time + 1)
        for repeat, recorded in enumerate(found):
            if repeat == entry.place.repeat:
                frame = recorded.message.header.frame_id
                try:
                    pose = recorded_pose(bag, self._options, index, entry.place, frame, entry.stamp)
                    return Scan(points_of(cloud_of(recorded.message)), pose, entry.stamp, frame)
                except CellError as reason:
                    raise CommandError(
                        f"the scan of the time {entry.stamp:.3f} in {self._options.path}: {reason}",
                        Outcome.NOT_DONE,
                    ) from reason
        raise CellError(
            f"{self._options.path} no longer holds the scan of {entry.stamp:.3f}; do not change it"
        )
