"""From a scan of a moving belt to the tracks of its objects, and to labels of them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from beltsort.cell.protocols import Scan
from beltsort.perception import Finding, Perceived, Perception, find_cups
from beltsort.tracking.smear import without_smear
from beltsort.tracking.tracker import Sighting, Tracker, TrackingUpdate
from beltsort.tracking.tracks import Expected
from beltsort.util.representation import short_repr

PLACE_ERROR = 0.006
"""Standard deviation of a cup's place in a scan, metres: repeatability of a compliant arm, mostly."""


@dataclass(frozen=True)
class TrackedLook:
    """What a scan shows of one place of the belt.

    Attributes
    ----------
    place
        Its x in the world frame in the middle of the exposure, metres.
    track
        Id of the track; None if there is no object, or its track is not certain.
    perceived
        Candidate, finding and label.
    """

    place: float
    track: int | None
    perceived: Perceived


@dataclass(frozen=True)
class TrackedScan:
    """What a scan of a moving belt shows.

    Attributes
    ----------
    looks
        One for each cup seen, and for each track where no cup was seen.
    update
        What it did to the tracks.
    """

    looks: tuple[TrackedLook, ...]
    update: TrackingUpdate

    __repr__ = short_repr


def track_scan(
    scan: Scan,
    tracker: Tracker,
    perception: Perception,
    *,
    exposure: float = 0.0,
    place_error: float = PLACE_ERROR,
) -> TrackedScan:
    """Find the objects in a scan, wherever they are along the belt, label them and update their tracks.

    The scan is dated at the middle of its exposure, not at its arrival. Candidates are cut where cups are
    seen, and where a track must be and no cup is seen. A track is missed if its place is seen without it, but
    not if the place is hidden or outside the image.

    Parameters
    ----------
    scan
        The scan, its pose in the belt frame as of the middle of the exposure.
    tracker
        The tracks, which are updated.
    perception
        Classifier and settings; of its layout, the cups' sizes are used.
    exposure
        Time in which the camera reads its rows from top to bottom, seconds, which is then corrected
        (`without_smear`); 0 for a camera that exposes all of them at once.
    place_error
        Standard deviation of the place of a cup in a scan, metres.

    Raises
    ------
    TrackingError
        If the scan is not newer than the last one, or nothing is known about the belt's travel at its time.
    CloudError
        If the scan is no point cloud or holds no finite point.
    """
    middle = scan.stamp + exposure / 2.0
    tracker.check_order(middle)
    if exposure > 0.0:
        scan = without_smear(scan, tracker.motion, exposure)
    layout = perception.layout
    cups = [cup.place for cup in find_cups(scan, layout, perception.config)]
    unseen = list(_without_cup(tracker.expected(middle), cups, tracker.config.gate))
    # Where another cup stands in the way, a track's own cannot be.
    blocked = [place for place in unseen if _nearest(place, cups) < 2.0 * layout.rim_radius]
    places = [*cups, *(place for place in unseen if place not in blocked)]
    perceived = perception(scan, layout.at(places))
    errors = [place_error if n < len(cups) else math.inf for n in range(len(places))]
    sightings = [
        Sighting(place, seen.finding, error)
        for place, seen, error in zip(places, perceived, errors, strict=True)
    ]
    update = tracker.update(middle, [*sightings, *(Sighting(place, Finding.EMPTY) for place in blocked)])
    looks = zip(places, update.tracks, perceived, strict=False)  # none of what is blocked
    return TrackedScan(tuple(TrackedLook(*look) for look in looks), update)


@dataclass(frozen=True)
class TrackedPerception:
    """`track_scan` with a classifier and a camera.

    Attributes
    ----------
    perception
        Classifier and settings.
    exposure, place_error
        As in `track_scan`.
    """

    perception: Perception
    exposure: float = 0.0
    place_error: float = PLACE_ERROR

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the labels."""
        return self.perception.labels

    def __call__(self, scan: Scan, tracker: Tracker) -> TrackedScan:
        """Return what `track_scan` returns."""
        return track_scan(
            scan, tracker, self.perception, exposure=self.exposure, place_error=self.place_error
        )


def _without_cup(expected: Sequence[Expected], cups: Sequence[float], gate: float) -> Iterator[float]:
    """Yield the places of tracks near which no cup is seen, metres."""
    return (track.place for track in expected if _nearest(track.place, cups) >= gate)


def _nearest(place: float, cups: Sequence[float]) -> float:
    """Return the distance from a place to the nearest cup, metres; infinite if there is none."""
    return min((abs(place - cup) for cup in cups), default=math.inf)
