import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.errors import TrackingError
from beltsort.tracking import BeltMotion, EncoderReading, MotionConfig
from tests.laws import cases

EXACT = MotionConfig(reading_error=0.0, most_acceleration=0.0)


def motion_of(*readings: tuple[float, float], config: MotionConfig | None = None) -> BeltMotion:
    motion = BeltMotion(config)
    for stamp, travel in readings:
        motion.add(EncoderReading(stamp, travel))
    return motion


@cases(50)
@given(st.floats(0.0, 1.9), st.lists(st.floats(0.01, 0.2), min_size=2, max_size=20), st.floats(0.0, 1.0))
def test_a_steady_belt_is_known_exactly_at_any_time(speed: float, steps: list[float], share: float) -> None:
    stamps = [sum(steps[:n]) for n in range(len(steps) + 1)]
    motion = motion_of(*((stamp, speed * stamp) for stamp in stamps), config=EXACT)
    time = share * (stamps[-1] + EXACT.longest_gap)
    assert motion.travel(time).metres == pytest.approx(speed * time, abs=1e-9)
    assert motion.travel(time).error == 0.0


@cases(50)
@given(st.floats(-1.0, 1.0), st.floats(0.0, 1.2))
def test_the_error_covers_what_the_belt_may_do_between_and_after_readings(a: float, share: float) -> None:
    config = MotionConfig(reading_error=0.0, most_acceleration=abs(a))

    def travel(time: float) -> float:
        return 0.5 * time + a / 2.0 * time**2

    motion = motion_of(*((n / 10.0, travel(n / 10.0)) for n in range(6)), config=config)
    time = share * 0.5
    told = motion.travel(time)
    assert abs(told.metres - travel(time)) <= 3.0 * told.error + 1e-12


def test_errors_of_readings_grow_with_extrapolation() -> None:
    motion = motion_of((0.0, 0.0), (0.1, 0.01))
    errors = [motion.travel(time).error for time in (0.1, 0.15, 0.25)]
    assert errors == sorted(errors)
    assert errors[0] == MotionConfig().reading_error


def test_a_speed_is_integrated() -> None:
    motion = BeltMotion()
    for stamp, speed in ((1.0, 0.1), (1.1, 0.1), (1.3, 0.3)):
        motion.add_speed(stamp, speed)
    assert motion.travel(1.3).metres == pytest.approx(0.01 + 0.04)


@pytest.mark.parametrize("stamp", [1.0, 0.9])
def test_stamps_that_go_back_are_refused(stamp: float) -> None:
    motion = motion_of((0.0, 0.0), (1.0, 0.1))
    with pytest.raises(TrackingError, match=r"expected after 1\.000 s"):
        motion.add(EncoderReading(stamp, 0.1))
    assert motion.travel(1.1).metres == pytest.approx(0.11)


@pytest.mark.parametrize("travel", [5.0, 0.0, float("nan")])
def test_jumps_are_refused_and_change_nothing(travel: float) -> None:
    motion = motion_of((0.0, 0.0), (1.0, 0.1))
    with pytest.raises(TrackingError, match=r"jumped or was reset|finite"):
        motion.add(EncoderReading(1.1, travel))
    motion.add(EncoderReading(1.1, 0.11))
    assert motion.travel(1.05).metres == pytest.approx(0.105)


@pytest.mark.parametrize("time", [-0.1, 1.3])
def test_times_of_which_nothing_is_known_are_told(time: float) -> None:
    motion = motion_of((0.0, 0.0), (1.0, 0.1))
    with pytest.raises(TrackingError, match=r"expected 0\.000"):
        motion.travel(time)


def test_one_reading_tells_no_speed() -> None:
    motion = motion_of((1.0, 0.1))
    assert motion.travel(1.0).metres == 0.1
    with pytest.raises(TrackingError, match="expected two or more"):
        motion.travel(1.05)
    with pytest.raises(TrackingError, match="no reading"):
        BeltMotion().travel(0.0)


def test_old_readings_are_dropped_but_not_those_within_the_memory() -> None:
    motion = motion_of(*((n / 1.0, 0.1 * n) for n in range(100)), config=MotionConfig(memory=10.0))
    assert motion.travel(89.5).metres == pytest.approx(8.95)
    with pytest.raises(TrackingError, match="the oldest reading kept"):
        motion.travel(80.0)


def test_settings_out_of_range_are_refused() -> None:
    with pytest.raises(TrackingError, match="memory is -1"):
        MotionConfig(memory=-1.0)
