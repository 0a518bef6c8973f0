"""Assignment of what scans show to tracks of objects on a moving belt.

In the belt's own coordinate, x plus travel, an object stands still, so that a track is one number and its
spread: a Kalman filter with a constant state. A candidate belongs to a track if they are nearer than the
*gate*. Objects are at least two gates apart, so that a candidate is within the gate of one track at most, and
no optimal assignment has to be computed. Where this does not hold, the assignment would be a guess: none is
made, and the ambiguity is told (`Ambiguous`).
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from beltsort.errors import TrackingError
from beltsort.perception.finding import Finding
from beltsort.tracking.motion import BeltMotion, Travel
from beltsort.tracking.tracks import (
    Ambiguous,
    Expected,
    LossReason,
    Lost,
    Passed,
    TooClose,
    Track,
    TrackingEvent,
)
from beltsort.util.naming import suggests_keywords
from beltsort.util.representation import short_repr

NOTHING = (Finding.EMPTY, Finding.HIDDEN)
CERTAIN = 3.0  # standard deviations of a track's place that must lie within the gate


@suggests_keywords
@dataclass(frozen=True)
class TrackerConfig:
    """Settings of a tracker.

    Attributes
    ----------
    gate
        A candidate nearer to a track than this is the track's object, metres. At most half the least distance
        of two objects, and well above the errors of places: too large makes scans ambiguous, too small opens
        a second track for the same object.
    exit
        The x in the world frame at which objects leave, metres.
    most_missed
        A track is lost after so many scans in a row that see its place without it.
    scale_error
        Standard deviation of the encoder's scale, a share; by it expected places err as the belt moves.
    slip
        Standard deviation by which an object moves on the belt between two scans, metres.
    """

    gate: float = 0.05
    exit: float = -0.05
    most_missed: int = 2
    scale_error: float = 0.005
    slip: float = 0.001

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name, value, right in (
            ("gate", self.gate, self.gate > 0.0),
            ("exit", self.exit, True),
            ("most_missed", self.most_missed, self.most_missed >= 1),
            ("scale_error", self.scale_error, self.scale_error >= 0.0),
            ("slip", self.slip, self.slip >= 0.0),
        ):
            if not (right and math.isfinite(value)):
                raise TrackingError(
                    f"{name} is {value}, expected in range and finite: start from the default"
                )


@dataclass(frozen=True)
class Sighting:
    """What a scan shows at one place of the belt.

    Attributes
    ----------
    place
        Its x in the world frame, metres.
    finding
        What was found there.
    error
        Standard deviation of `place`, metres; infinite if the place was not measured, but expected.
    """

    place: float
    finding: Finding = Finding.OBJECT
    error: float = 0.006


@dataclass(frozen=True)
class TrackingUpdate:
    """What a scan did to the tracks.

    Attributes
    ----------
    stamp
        Its exposure time, seconds on the cell's clock.
    tracks
        Id of the track of each sighting; None for places without an object, for ambiguous ones and for
        objects that have left.
    opened
        Ids of the new tracks.
    events
        What else is to be told, in order.
    """

    stamp: float
    tracks: tuple[int | None, ...]
    opened: tuple[int, ...]
    events: tuple[TrackingEvent, ...]

    __repr__ = short_repr


class Tracker:
    """Tracks of the objects on a belt.

    Scans are given in the order of their exposures, however late they arrive; one that is older than the
    newest is refused, and changes nothing.

    Parameters
    ----------
    motion
        The motion of the belt, to which its readings are added.
    config
        Settings.

    Examples
    --------
    >>> from beltsort.tracking import BeltMotion, EncoderReading
    >>> motion = BeltMotion()
    >>> for stamp in (0.0, 0.5, 1.0):
    ...     motion.add(EncoderReading(stamp, 0.1 * stamp))
    >>> tracker = Tracker(motion)
    >>> tracker.update(0.2, [Sighting(0.30), Sighting(0.11)]).tracks
    (0, 1)
    >>> tracker.update(0.8, [Sighting(0.05), Sighting(0.24)]).tracks
    (1, 0)
    >>> [(expected.track, round(expected.place, 3)) for expected in tracker.expected(1.0)]
    [(1, 0.03), (0, 0.22)]
    """

    def __init__(self, motion: BeltMotion, config: TrackerConfig | None = None) -> None:
        self.motion = motion
        self.config = TrackerConfig() if config is None else config
        self._tracks: dict[int, Track] = {}
        self._leaving: list[Track] = []  # passed, and perhaps still seen
        self._next, self._newest = 0, -math.inf

    @property
    def tracks(self) -> tuple[Track, ...]:
        """The tracks of objects on the belt, the most downstream first."""
        return tuple(sorted(self._tracks.values(), key=lambda track: track.position))

    def expected(self, stamp: float) -> tuple[Expected, ...]:
        """Return where each track is at a time, seconds on the cell's clock, the most downstream first.

        Raises
        ------
        TrackingError
            If nothing is known about the belt's travel at that time (`BeltMotion.travel`).
        """
        travel = self.motion.travel(stamp)
        return tuple(
            Expected(track.id, track.position - travel.metres, self._spread(track, travel))
            for track in self.tracks
        )

    def check_order(self, stamp: float) -> None:
        """Raise a `TrackingError` if a scan of that exposure time is not newer than the last one."""
        if not stamp > self._newest:
            raise TrackingError(
                f"the scan was exposed at {stamp:.3f} s, expected after {self._newest:.3f} s, when the "
                "newest one was: give scans in the order of their exposures, each once; this one is not used"
            )

    def update(self, stamp: float, sightings: Sequence[Sighting]) -> TrackingUpdate:
        """Assign what a scan shows to tracks, open new ones, and tell which ones are gone.

        Parameters
        ----------
        stamp
            Time of the exposure, its middle, seconds on the cell's clock.
        sightings
            What the scan shows, in any order; places that it does not show are left out or `HIDDEN`.

        Raises
        ------
        TrackingError
            If the scan is not newer than the last one, a place or its error is not finite or not above 0, or
            nothing is known about the belt's travel at that time.
        """
        self.check_order(stamp)
        for sighting in sightings:
            if not (math.isfinite(sighting.place) and sighting.error > 0.0):
                raise TrackingError(
                    f"the sighting is {sighting}, expected a finite place and an error above 0"
                )
        travel = self.motion.travel(stamp)
        self._newest = stamp
        events: list[TrackingEvent] = []
        near = {
            index: self._near(sighting, self.tracks, travel)
            for index, sighting in enumerate(sightings)
            if sighting.finding not in NOTHING
        }
        owner = {}
        for objects, tracks in _groups(near):
            if len(objects) == len(tracks) == 1:
                owner[objects[0]] = tracks[0]
                self._tracks[tracks[0]] = self._fused(tracks[0], sightings[objects[0]], stamp, travel)
            else:
                events.append(Ambiguous(stamp, tuple(sightings[i].place for i in objects), tuple(tracks)))
        events += self._lose(stamp, sightings, travel, present={id_ for ids in near.values() for id_ in ids})
        opened = []
        for index in (index for index, tracks in near.items() if not tracks):
            if (track := self._opened(stamp, sightings[index], travel)) is not None:
                owner[index] = track.id
                opened.append(track.id)
                events += self._too_close(stamp, track)
                self._tracks[track.id] = track
        events += self._leave(stamp, travel)
        ids = tuple(owner.get(index) for index in range(len(sightings)))
        return TrackingUpdate(stamp, ids, tuple(opened), tuple(events))

    def _spread(self, track: Track, travel: Travel) -> float:
        """Return the standard deviation of a track's position at some travel, metres."""
        drift = self.config.scale_error * (travel.metres - track.seen_at)
        return math.hypot(track.spread, drift, travel.error, self.config.slip)

    def _near(self, sighting: Sighting, tracks: Iterable[Track], travel: Travel) -> list[int]:
        """Return the ids of the tracks within the gate of a sighting."""
        position = sighting.place + travel.metres
        return [track.id for track in tracks if abs(track.position - position) < self.config.gate]

    def _fused(self, id_: int, sighting: Sighting, stamp: float, travel: Travel) -> Track:
        """Return a track after its object was seen: a step of a Kalman filter with a constant state."""
        track = self._tracks[id_]
        spread = self._spread(track, travel)
        position = track.position
        if math.isfinite(sighting.error):
            gain = spread**2 / (spread**2 + sighting.error**2)
            position += gain * (sighting.place + travel.metres - position)
            spread *= math.sqrt(1.0 - gain)
        scans = track.scans + 1
        return replace(
            track,
            position=position,
            spread=spread,
            seen_at=travel.metres,
            last_seen=stamp,
            scans=scans,
            missed=0,
        )

    def _lose(
        self, stamp: float, sightings: Sequence[Sighting], travel: Travel, present: set[int]
    ) -> Iterator[Lost]:
        """Count the tracks that were due and not seen, and drop those that are lost.

        Parameters
        ----------
        present
            Ids of the tracks near which an object was seen.
        """
        empty = [sighting for sighting in sightings if sighting.finding is Finding.EMPTY]
        absent = {id_ for sighting in empty for id_ in self._near(sighting, self.tracks, travel)} - present
        for track in self.tracks:
            if track.id in absent:
                self._tracks[track.id] = track = replace(track, missed=track.missed + 1)
            if track.missed >= self.config.most_missed:
                yield Lost(stamp, self._tracks.pop(track.id), LossReason.NOT_SEEN)
            elif CERTAIN * self._spread(track, travel) > self.config.gate:
                yield Lost(stamp, self._tracks.pop(track.id), LossReason.UNCERTAIN)

    def _opened(self, stamp: float, sighting: Sighting, travel: Travel) -> Track | None:
        """Return a new track of an object; None if it has left already."""
        if sighting.place < self.config.exit or self._near(sighting, self._leaving, travel):
            return None
        track = Track(
            self._next, sighting.place + travel.metres, min(sighting.error, self.config.gate / CERTAIN),
            travel.metres, stamp, stamp,
        )  # fmt: skip
        self._next += 1
        return track

    def _too_close(self, stamp: float, opened: Track) -> Iterator[TooClose]:
        """Tell the tracks whose gate overlaps that of a new one."""
        for other in self.tracks:
            distance = abs(other.position - opened.position)
            if distance < 2.0 * self.config.gate:
                yield TooClose(stamp, opened.id, other.id, distance)

    def _leave(self, stamp: float, travel: Travel) -> Iterator[Passed]:
        """Drop the tracks that have passed the exit; their objects are still seen for a while."""
        limit = travel.metres + self.config.exit
        self._leaving = [track for track in self._leaving if track.position > limit - 2.0 * self.config.gate]
        for track in self.tracks:
            if track.position < limit:
                self._leaving.append(self._tracks.pop(track.id))
                yield Passed(stamp, track)


def _groups(near: Mapping[int, Sequence[int]]) -> Iterator[tuple[list[int], list[int]]]:
    """Yield objects, by index, and tracks, by id, that are within the gate of each other, group by group."""
    waiting = {index: set(tracks) for index, tracks in near.items() if tracks}
    while waiting:
        first = min(waiting)
        objects, tracks = [first], waiting.pop(first)
        while joined := [other for other, its in waiting.items() if its & tracks]:
            for other in joined:
                objects.append(other)
                tracks |= waiting.pop(other)
        yield sorted(objects), sorted(tracks)
