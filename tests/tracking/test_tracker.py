"""Laws of tracks: an object keeps its id, two objects never share one, and what is doubtful is told."""

import math
from itertools import pairwise
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.errors import TrackingError
from beltsort.tracking import (
    Ambiguous,
    LossReason,
    Lost,
    Passed,
    Sighting,
    TooClose,
    Tracker,
    TrackerConfig,
)
from tests.laws import cases
from tests.tracking.belts import empty, motion_at, seen

GATE = TrackerConfig().gate
SPEEDS = st.floats(0.01, 0.5)
PITCHES = st.lists(st.floats(2.0 * GATE, 0.3), min_size=1, max_size=15)


def positions_of(pitches: list[float]) -> list[float]:
    """Return where objects stand on the belt, some of which are in view at time 0."""
    return [sum(pitches[:n]) for n in range(len(pitches) + 1)]


def stamps_of(speed: float, positions: list[float]) -> list[float]:
    """Return times of scans until all objects have left, the belt moving 4 cm between them, at most 10 s."""
    count = int((positions[-1] + 0.2) / 0.04)
    return [t for n in range(count) if (t := n * 0.04 / speed) < 10.0]


@cases(60)
@given(SPEEDS, PITCHES, st.randoms(use_true_random=False))
def test_every_object_has_one_id_of_its_own_if_they_are_a_pitch_apart(
    speed: float, pitches: list[float], random: Random
) -> None:
    positions, tracker = positions_of(pitches), Tracker(motion_at(speed))
    track_of: dict[int, int] = {}
    passed: list[int] = []
    for stamp in stamps_of(speed, positions):
        # Each place errs by less than half of the gate.
        errors = [random.uniform(-0.49, 0.49) * GATE for _ in positions]
        shown = seen(positions, speed * stamp, errors)
        random.shuffle(shown)
        update = tracker.update(stamp, [sighting for _, sighting in shown])
        for (number, _), track in zip(shown, update.tracks, strict=True):
            if track is not None:
                assert track_of.setdefault(number, track) == track
        passed += [event.track.id for event in update.events if isinstance(event, Passed)]
        assert not any(isinstance(event, Ambiguous | Lost) for event in update.events)
    assert len(set(track_of.values())) == len(track_of)
    assert len(set(passed)) == len(passed)
    assert set(passed) <= set(track_of.values())


@cases(40)
@given(SPEEDS, PITCHES)
def test_exact_scans_know_exact_places_and_tell_each_object_once_when_it_leaves(
    speed: float, pitches: list[float]
) -> None:
    positions, tracker = positions_of(pitches), Tracker(motion_at(speed))
    passed = []
    for stamp in stamps_of(speed, positions):
        update = tracker.update(stamp, [sighting for _, sighting in seen(positions, speed * stamp)])
        passed += [event.track.position for event in update.events if isinstance(event, Passed)]
        for expected in tracker.expected(stamp):
            assert min(abs(expected.place + speed * stamp - position) for position in positions) < 1e-6
        assert len(tracker.tracks) == len({track.id for track in tracker.tracks})
    last = speed * stamps_of(speed, positions)[-1]
    assert passed == pytest.approx([p for p in positions if p - last < TrackerConfig().exit - 1e-9], abs=1e-6)


@cases(40)
@given(SPEEDS, PITCHES, st.floats(0.0, 5.0))
def test_a_scan_that_arrives_late_gives_the_same_tracks(
    speed: float, pitches: list[float], delay: float
) -> None:
    """All that counts is the time of its exposure: readings that came in between change nothing."""
    positions = positions_of(pitches)
    stamps = [stamp for stamp in stamps_of(speed, positions) if stamp < 5.0]
    in_time, late = (
        Tracker(motion_at(speed, end=math.ceil(stamps[-1]) + more)) for more in (1.0, 1.0 + delay)
    )
    for stamp in stamps:
        shown = [sighting for _, sighting in seen(positions, speed * stamp)]
        assert in_time.update(stamp, shown) == late.update(stamp, shown)
    assert in_time.tracks == late.tracks


def test_a_scan_out_of_order_is_refused_and_changes_nothing() -> None:
    tracker = Tracker(motion_at(0.1))
    tracker.update(2.0, [Sighting(0.1), Sighting(0.28)])
    before = tracker.tracks
    for stamp in (1.0, 2.0):
        with pytest.raises(TrackingError, match=r"exposed at .* expected after 2\.000 s"):
            tracker.update(stamp, [Sighting(0.2)])
    assert tracker.tracks == before


def test_a_scan_of_an_unknown_time_changes_nothing() -> None:
    tracker = Tracker(motion_at(0.1))
    tracker.update(2.0, [Sighting(0.1)])
    with pytest.raises(TrackingError, match="longest_gap"):
        tracker.update(20.0, [Sighting(0.1)])
    assert tracker.update(2.1, [Sighting(0.09)]).tracks == (0,)


@pytest.mark.parametrize("sighting", [Sighting(math.nan), Sighting(0.1, error=0.0)])
def test_impossible_places_are_refused(sighting: Sighting) -> None:
    with pytest.raises(TrackingError, match="expected a finite place"):
        Tracker(motion_at(0.1)).update(1.0, [sighting])


def test_two_objects_for_one_track_are_told_and_neither_is_taken() -> None:
    tracker = Tracker(motion_at(0.0))
    tracker.update(1.0, [Sighting(0.1)])
    before = tracker.tracks
    update = tracker.update(2.0, [Sighting(0.08), Sighting(0.13), Sighting(0.28)])
    assert update.tracks == (None, None, 1)
    assert update.events == (Ambiguous(2.0, (0.08, 0.13), (0,)),)
    assert tracker.tracks[:1] == before
    assert tracker.update(3.0, [Sighting(0.1), Sighting(0.28)]).tracks == (0, 1)


def test_one_object_for_two_tracks_is_told_and_neither_gets_it() -> None:
    tracker = Tracker(motion_at(0.0))
    opening = tracker.update(1.0, [Sighting(0.1), Sighting(0.16)])
    assert opening.opened == (0, 1)
    (close,) = opening.events
    assert isinstance(close, TooClose)
    assert (close.opened, close.other) == (1, 0)
    assert close.distance == pytest.approx(0.06)
    update = tracker.update(2.0, [Sighting(0.13)])
    assert update.tracks == (None,)
    assert update.events == (Ambiguous(2.0, (0.13,), (0, 1)),)


def test_two_objects_at_once_within_the_gate_stay_two() -> None:
    tracker = Tracker(motion_at(0.0))
    update = tracker.update(1.0, [Sighting(0.1), Sighting(0.12)])
    assert update.tracks == (0, 1)
    assert any(isinstance(event, TooClose) for event in update.events)


def test_a_track_is_lost_where_its_place_is_seen_without_it_repeatedly() -> None:
    tracker = Tracker(motion_at(0.0))
    tracker.update(1.0, [Sighting(0.1)])
    assert tracker.update(1.5, [empty(0.11)]).events == ()
    assert tracker.tracks[0].missed == 1
    assert tracker.update(2.0, [Sighting(0.1)]).tracks == (0,)
    assert tracker.tracks[0].missed == 0
    events = [event for stamp in (2.5, 3.0) for event in tracker.update(stamp, [empty(0.09)]).events]
    (lost,) = events
    assert isinstance(lost, Lost)
    assert (lost.stamp, lost.track.id, lost.reason) == (3.0, 0, LossReason.NOT_SEEN)
    assert tracker.update(4.0, [Sighting(0.1)]).opened == (1,)


def test_what_a_scan_does_not_show_is_not_missed() -> None:
    tracker = Tracker(motion_at(0.0))
    tracker.update(1.0, [Sighting(0.1)])
    for stamp in (2.0, 3.0, 4.0, 5.0):
        assert tracker.update(stamp, []).events == ()
    assert tracker.tracks[0].missed == 0


def test_a_track_is_lost_when_its_place_is_no_longer_known() -> None:
    tracker = Tracker(motion_at(0.2), TrackerConfig(scale_error=0.05, exit=-2.0))
    tracker.update(0.1, [Sighting(0.3)])
    (lost,) = tracker.update(2.1, []).events
    assert isinstance(lost, Lost)
    assert lost.reason is LossReason.UNCERTAIN


def test_an_object_that_left_is_no_new_one_while_it_is_still_seen() -> None:
    tracker = Tracker(motion_at(0.1))
    tracker.update(0.1, [Sighting(0.0)])
    update = tracker.update(0.7, [Sighting(-0.06)])
    assert isinstance(update.events[0], Passed)
    assert tracker.update(0.75, [Sighting(-0.045)]).tracks == (None,)
    assert tracker.tracks == ()


def test_seeing_an_object_again_narrows_its_place() -> None:
    tracker = Tracker(motion_at(0.0))
    spreads = []
    for n in range(4):
        tracker.update(1.0 + n, [Sighting(0.1)])
        spreads.append(tracker.tracks[0].spread)
    assert all(after < before for before, after in pairwise(spreads))


def test_an_expected_place_is_no_measurement() -> None:
    tracker = Tracker(motion_at(0.0))
    tracker.update(1.0, [Sighting(0.1)])
    tracker.update(2.0, [Sighting(0.12, error=math.inf)])
    (track,) = tracker.tracks
    assert track.position == 0.1
    assert track.scans == 2


def test_settings_out_of_range_are_refused() -> None:
    with pytest.raises(TrackingError, match=r"gate is 0\.0, expected"):
        TrackerConfig(gate=0.0)
