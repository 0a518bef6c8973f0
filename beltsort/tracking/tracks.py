"""Tracks of objects on a moving belt, and what is told about them."""

from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias


@dataclass(frozen=True)
class Track:
    """An object that was seen on the belt.

    Attributes
    ----------
    id
        Its number; none is used twice.
    position
        Where it stands on the belt: its x in the world frame plus the belt's travel, metres. It does not
        change while the object stays where it is on the belt.
    spread
        Standard deviation of `position` when it was last seen, metres.
    seen_at
        Travel of the belt when it was last seen, metres.
    first_seen, last_seen
        Exposure times of the first and the last scan in which it was seen, seconds on the cell's clock.
    scans
        Number of scans in which it was seen.
    missed
        Number of scans since in which it was due and its place was seen without it.
    """

    id: int
    position: float
    spread: float
    seen_at: float
    first_seen: float
    last_seen: float
    scans: int = 1
    missed: int = 0


@dataclass(frozen=True)
class Expected:
    """Where a track is expected at some time.

    Attributes
    ----------
    track
        Its id.
    place
        Its x in the world frame, metres.
    spread
        Standard deviation of `place`, metres.
    """

    track: int
    place: float
    spread: float


class LossReason(StrEnum):
    """Why a track is lost."""

    NOT_SEEN = "its place was seen without it"
    UNCERTAIN = "its place is no longer known to within the gate"


@dataclass(frozen=True)
class Lost:
    """A track was dropped before it left the belt.

    Attributes
    ----------
    stamp
        Exposure time of the scan, seconds on the cell's clock.
    track
        The track as it was.
    reason
        Why.
    """

    stamp: float
    track: Track
    reason: LossReason


@dataclass(frozen=True)
class Passed:
    """A track left by the exit.

    Attributes
    ----------
    stamp
        Time by which it had, seconds on the cell's clock.
    track
        The track as it was.
    """

    stamp: float
    track: Track


@dataclass(frozen=True)
class Ambiguous:
    """Objects and tracks that cannot be told apart; none of them was assigned.

    Attributes
    ----------
    stamp
        Exposure time of the scan, seconds on the cell's clock.
    places
        The x of each object seen, metres.
    tracks
        Ids of the tracks.
    """

    stamp: float
    places: tuple[float, ...]
    tracks: tuple[int, ...]


@dataclass(frozen=True)
class TooClose:
    """A new track is nearer to another one than two gates: later scans may be ambiguous.

    Attributes
    ----------
    stamp
        Exposure time of the scan, seconds on the cell's clock.
    opened, other
        Ids of the new track and of the other.
    distance
        Metres between them.
    """

    stamp: float
    opened: int
    other: int
    distance: float


TrackingEvent: TypeAlias = Lost | Passed | Ambiguous | TooClose
