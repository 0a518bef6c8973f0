"""Whole scans of a moving belt: found, dated, labelled and tracked."""

from dataclasses import replace

import pytest

from beltsort.errors import TrackingError
from beltsort.perception import Finding, Perception
from beltsort.sim import BeltDrive, CellConfig, MovingCell
from beltsort.sim.prepare import prepare
from beltsort.tracking import BeltMotion, TrackedScan, Tracker, TrackerConfig, track_scan, without_smear

EXPOSURE, EXIT = 0.03, TrackerConfig().exit


@pytest.fixture(scope="module")
def perception() -> Perception:
    return Perception(CellConfig().layout, prepare().database)


class Line:
    """A moving belt with tracker, seen from above, that is scanned now and then."""

    def __init__(self, perception: Perception, *classes: int | None, speed: float = 0.2) -> None:
        self.cell = MovingCell(classes, BeltDrive(speed, pitch_jitter=0.008, exposure=EXPOSURE), seed=11)
        self.cell.set_speed(0.0)
        self.cell.move_to(2, "move")
        self.cell.set_speed(speed)
        self.motion, self.perception = BeltMotion(), perception
        self.tracker = Tracker(self.motion)
        self.motion.add(self.cell.encoder())

    def scan(self, wait: float = 0.2) -> TrackedScan:
        self.cell.wait(wait)
        self.motion.add(self.cell.encoder())
        scan = self.cell.scan(not_before=0.0)
        self.motion.add(self.cell.encoder())
        return track_scan(scan, self.tracker, self.perception, exposure=EXPOSURE)


def test_objects_keep_their_track_while_they_move_and_their_places_are_known(perception: Perception) -> None:
    line = Line(perception, 0, 1, None, 2, 3)
    number_of: dict[int, int] = {}
    for _ in range(6):
        seen = line.scan()
        truth = {n: line.cell.place(n, seen.update.stamp) for n in range(8)}
        for look in seen.looks:
            number = min(truth, key=lambda n: abs(truth[n] - look.place))
            assert look.place == pytest.approx(truth[number], abs=0.02)
            if look.place > EXIT + 0.02:
                assert (look.track is None) == (number == 2 or number > 4)
            if look.track is not None:
                assert number_of.setdefault(look.track, number) == number
        for expected in line.tracker.expected(seen.update.stamp):
            assert expected.place == pytest.approx(truth[number_of[expected.track]], abs=0.02)
    assert len(set(number_of.values())) == len(number_of) >= 4


def test_most_labels_of_a_slow_belt_are_right(perception: Perception) -> None:
    line = Line(perception, 0, 1, 2, 3, speed=0.05)
    looks = [look for _ in range(3) for look in line.scan().looks if look.perceived.label is not None]
    right = 0
    for look in looks:
        truth = line.cell.on_belt()
        number = min(truth, key=lambda n: abs(truth[n] - look.place))
        right += look.perceived.label == line.cell.true_class(number)
    assert len(looks) >= 6
    assert right > len(looks) / 2


def test_a_removed_object_is_lost(perception: Perception) -> None:
    line = Line(perception, 0, 1, speed=0.02)
    opened = line.scan().update.opened
    assert len(opened) == 2
    assert line.cell.take(1)
    assert not line.cell.take(1)
    seen = [line.scan(), line.scan()]
    (look,) = (look for look in seen[-1].looks if 0.1 < look.place < 0.2)
    assert look.perceived.finding is Finding.EMPTY
    assert look.track is None
    (lost,) = (event for scan in seen for event in scan.update.events)
    assert lost.track.id == 1  # type: ignore[union-attr]


def test_a_scan_twice_is_refused(perception: Perception) -> None:
    line = Line(perception, 0)
    line.cell.wait(0.2)
    scan = line.cell.scan(not_before=0.0)
    line.motion.add(line.cell.encoder())
    track_scan(scan, line.tracker, perception, exposure=EXPOSURE)
    before = line.tracker.tracks
    with pytest.raises(TrackingError, match="each once"):
        track_scan(scan, line.tracker, perception, exposure=EXPOSURE)
    assert line.tracker.tracks == before


def test_an_exposure_needs_rows(perception: Perception) -> None:
    line = Line(perception, 0)
    scan = line.cell.scan(not_before=0.0)
    line.motion.add(line.cell.encoder())
    with pytest.raises(TrackingError, match=r"expected \(height, width, 3\)"):
        without_smear(replace(scan, points=scan.points.reshape(-1, 3)), line.motion, EXPOSURE)
    with pytest.raises(TrackingError, match="exposure is -1"):
        without_smear(scan, line.motion, -1.0)
