from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.cell import BeltReading, Health
from beltsort.sorting.holds import HeldError
from beltsort.sorting.moving.belt import BeltWatch
from beltsort.sorting.moving.record import MovingRecord, Patience
from beltsort.sorting.moving.state import MovingState
from tests.sorting.moving.runs import BELT


class Encoder:
    """A belt of which only readings are asked."""

    def __init__(self, readings: Iterator[BeltReading]) -> None:
        self.readings = readings

    def reading(self, *, timeout: float = 1.0) -> BeltReading:
        return next(self.readings)

    def health(self) -> Health:
        return Health(ready=True, boot_id="a")

    def stop(self) -> None:
        pass

    def divert(self, command_id: str, **_fields: object) -> object:
        raise NotImplementedError

    def diversion(self, command_id: str, **_fields: object) -> object:
        raise NotImplementedError


class Nowhere:
    """A journal that keeps nothing."""

    full = False

    def append(self, content: object) -> None:
        pass


def watch(readings: list[BeltReading]) -> BeltWatch:
    patience = Patience((), lambda _seconds: None, lambda: None)
    record = MovingRecord(Nowhere(), MovingState(BELT))  # type: ignore[arg-type] # it keeps nothing
    return BeltWatch(Encoder(iter(readings)), patience, record, 0.18)  # type: ignore[arg-type] # it diverts nothing


@given(
    st.lists(
        st.tuples(st.floats(0.001, 1.0), st.floats(-1.0, 1.0), st.floats(0.0, 0.2)), min_size=2, max_size=40
    ),
    st.floats(0.01, 0.9),
)
def test_a_clock_that_is_badly_known_is_no_jump_of_the_encoder(
    steps: list[tuple[float, float, float]], speed: float
) -> None:
    time, readings = 0.0, []
    for step, off, error in steps:
        time += step
        readings.append(BeltReading(time + off * error, speed * time, "a", error=error))
    belt = watch(readings)
    for _ in readings:
        belt.read()


def test_a_jump_of_the_encoder_is_told_and_tracks_begin_anew() -> None:
    belt = watch([BeltReading(0.1 * n, 0.02 * n, "a") for n in range(5)] + [BeltReading(0.6, 3.0, "a")])
    for _ in range(5):
        belt.read()
    before = belt.tracker
    with pytest.raises(HeldError, match=r"encoder jumped.*restart the controller, then resume"):
        belt.read()
    assert belt.tracker is not before


def test_after_a_jump_nothing_is_believed_until_the_controller_was_restarted() -> None:
    travels = [0.0, 0.02, 3.0, 3.02, 3.04]
    readings = [BeltReading(0.1 * n, travel, "a") for n, travel in enumerate(travels)]
    belt = watch([*readings, BeltReading(1.0, 0.1, "b"), BeltReading(1.1, 0.12, "b")])
    belt.read()
    belt.read()
    for _ in range(3):
        with pytest.raises(HeldError, match="restart the controller"):
            belt.read()
    assert [belt.read().boot_id for _ in range(2)] == ["b", "b"]


def test_tracks_begin_anew_when_the_controller_was_restarted() -> None:
    belt = watch([BeltReading(1.0, 5.0, "a"), BeltReading(2.0, 0.1, "b"), BeltReading(3.0, 0.2, "b")])
    belt.read()
    before = belt.tracker
    belt.read()
    belt.read()
    assert belt.tracker is not before
    assert belt.motion.travel(2.5).metres == pytest.approx(0.15)
