"""What the client of a belt that never stops does with its network and its clock; no process."""

from dataclasses import replace
from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.cell import CommandError, Diversion, DiversionStatus, DivertingBelt, Outcome
from beltsort.drivers.clock_bounds import DRIFT, ClockBounds
from beltsort.drivers.fieldbus import DivertingDevice
from beltsort.drivers.fieldbus.diversions import (
    DiversionReply,
    DiversionRequest,
    DiversionVerb,
    checked_diversion,
)
from beltsort.drivers.fieldbus.link import MissingPartError
from beltsort.drivers.fieldbus.wire import MEMORY, GarbageError, boot_id_of
from beltsort.errors import CellError
from beltsort.testing.diverting import DivertingController, DivertingMachine
from tests.contract.station import Station
from tests.laws import cases

SLOW = DivertingMachine(speed=1000, capacity=5)
"""Bins 1, 1.3 and 1.6 m behind the mark, and a belt that goes 1 mm per second."""


class DivertingStation(Station[DiversionRequest, DiversionReply]):
    """A controller whose clock began 500 s before the cell's, and whose round trips take time."""

    acting = (DiversionVerb.DIVERT,)

    def __init__(self, machine: DivertingMachine = SLOW) -> None:
        super().__init__()
        self.machine, self.time = machine, 0.0
        self.delay = 0.0
        self.boots = count(11)
        self.restart()

    def restart(self) -> None:
        self.boot = next(self.boots)
        self.controller: DivertingController = DivertingController(
            self.machine, self.boot, clock=lambda: 500.0 + self.time
        )
        self.reply = self.controller.look()

    def fresh(self) -> None:
        self.time += self.delay

    def shown(self) -> DiversionReply:
        return self.reply

    def device(self) -> DivertingDevice:
        return DivertingDevice(self.connect, "the station", answer_timeout=1.0, clock=lambda: self.time)

    @property
    def boot_id(self) -> str:
        return boot_id_of(self.boot)

    def divert(
        self, device: DivertingBelt, command_id: str, number: int, label: int = 0, boot_id: str = ""
    ) -> DiversionStatus:
        return device.divert(
            command_id,
            number=number,
            coordinate=0.1 * number,
            label=label,
            boot_id=boot_id or self.boot_id,
            timeout=0.3,
        )

    def state(self, device: DivertingBelt, command_id: str, boot_id: str = "") -> DiversionStatus:
        return device.diversion(command_id, boot_id=boot_id or self.boot_id)


def lost(station: DivertingStation, device: DivertingBelt, number: int) -> str:
    """Send a diversion, which the network holds back, and return its id."""
    station.holding = True
    with pytest.raises(CommandError, match=r"\bdiversion of object\b.*\bcannot be asked\b") as error:
        station.divert(device, f"lost {number}", number)
    assert error.value.outcome is Outcome.UNKNOWN
    station.holding = False
    return f"lost {number}"


def test_a_diversion_is_queued_and_carried_out() -> None:
    station = DivertingStation()
    device = station.device()
    assert station.divert(device, "first", 2, label=1) == DiversionStatus(Diversion.QUEUED, station.boot_id)
    station.time = 1500.0
    assert station.state(device, "first") == DiversionStatus(Diversion.DONE, station.boot_id)
    assert station.divert(device, "first", 2, label=1).state is Diversion.DONE
    assert station.controller.look().bins == (0, 1, 0)


def test_a_diversion_that_is_late_after_the_question_never_acts() -> None:
    station = DivertingStation()
    device = station.device()
    command_id = lost(station, device, 1)
    status = station.state(device, command_id)
    assert (status.state, status.retry) == (Diversion.NOT_DONE, True)
    station.deliver()
    assert station.controller.look().queued == 0
    assert station.divert(device, command_id, 1).state is Diversion.QUEUED


def test_a_diversion_that_is_late_before_the_question_is_queued_once() -> None:
    station = DivertingStation()
    device = station.device()
    command_id = lost(station, device, 1)
    station.deliver()
    assert station.state(device, command_id).state is Diversion.QUEUED
    assert station.divert(device, command_id, 1).state is Diversion.QUEUED
    assert station.controller.look().queued == 1


def test_one_that_was_certainly_not_sent_is_not_done_unless_it_was_sent_before() -> None:
    station = DivertingStation()
    device = station.device()
    command_id = lost(station, device, 1)

    station.wire.broken, station.refusing = True, True
    for number, outcome in ((1, Outcome.UNKNOWN), (2, Outcome.NOT_DONE)):
        with pytest.raises(CommandError, match="nobody listens") as error:
            station.divert(device, command_id if number == 1 else "another", number)
        assert error.value.outcome is outcome


def test_refusals_that_may_pass_are_told_from_outcomes() -> None:
    station = DivertingStation()
    device = station.device()
    station.divert(device, "queued", 1)
    station.controller.press(coasting=2_000_000)
    status = station.divert(device, "refused", 30)
    assert (status.state, status.retry) == (Diversion.NOT_DONE, True)
    assert "emergency stop" in status.reason
    status = station.divert(device, "queued", 1)
    assert (status.state, status.retry) == (Diversion.NOT_DONE, False)
    assert "emergency stop" in station.state(device, "queued").reason
    assert device.health().emergency_stop
    station.controller.release()
    assert station.divert(device, "refused", 30).state is Diversion.QUEUED
    for label, command_id, number in ((9, "no such bin", 40), (1, "refused", 30), (1, "other", 30)):
        status = station.divert(device, command_id, number, label=label)
        assert (status.state, status.retry) == (Diversion.NOT_DONE, False)
        assert status.reason


def test_after_a_restart_nothing_is_known_and_nothing_repeated() -> None:
    station = DivertingStation()
    device = station.device()
    before = station.boot_id
    station.divert(device, "queued", 1)
    station.restart()
    for asked in (device, station.device()):
        for _ in range(2):
            status = station.state(asked, "queued", before)
            assert (status.state, status.retry) == (Diversion.UNKNOWN, False)
            status = station.divert(asked, "queued", 1, boot_id=before)
            assert (status.state, status.boot_id) == (Diversion.UNKNOWN, station.boot_id)
            assert "restart" in status.reason
    assert station.controller.look().queued == 0


def test_what_an_earlier_program_sent_is_unknown_if_it_may_have_been_forgotten() -> None:
    station = DivertingStation(DivertingMachine(speed=1000, memory=2))
    device = station.device()
    status = station.state(device, "earlier")
    assert (status.state, status.retry) == (Diversion.NOT_DONE, True)
    station.time = 5000.0
    for number in range(4):
        assert station.divert(device, f"late {number}", number).state is Diversion.TOO_LATE
    assert station.state(device, "earlier").state is Diversion.UNKNOWN


@pytest.mark.parametrize(
    ("before", "since", "state"),
    [
        (0, 1, Diversion.UNKNOWN),
        (7, 1, Diversion.NOT_DONE),
        (7, MEMORY - 1, Diversion.NOT_DONE),
        (7, MEMORY, Diversion.UNKNOWN),
    ],
)
def test_a_lost_one_cannot_be_forgotten_before_those_that_were_in_a_full_memory(
    before: int, since: int, state: Diversion
) -> None:
    station = DivertingStation(DivertingMachine(memory=MEMORY))
    device = station.device()
    station.controller._forgotten = before
    command_id = lost(station, device, 1)
    station.controller._forgotten += since
    assert station.state(device, command_id).state is state


def test_a_reading_is_on_the_cells_clock() -> None:
    station = DivertingStation()
    device = station.device()
    station.time, station.delay = 7.0, 0.5
    first = device.reading()
    assert first == replace(first, boot_id=station.boot_id, moving=True, emergency_stop=False)
    assert (first.stamp, first.travel, first.error) == pytest.approx((7.25, 0.0075, 0.2501))
    station.delay = 0.125
    second = device.reading()
    assert second.error <= first.error
    assert abs(second.stamp - station.time) <= second.error
    station.restart()
    assert device.reading().boot_id != first.boot_id
    station.controller.press()
    stopped = device.reading()
    assert (stopped.moving, stopped.emergency_stop) == (False, True)


@cases(100)
@given(
    st.lists(
        st.tuples(st.floats(0.0, 500.0), st.floats(1e-4, 2.0), st.floats(0.0, 1.0)), min_size=1, max_size=20
    ),
    st.floats(-0.99 * DRIFT, 0.99 * DRIFT),
)
def test_the_clocks_bounds_hold_while_it_drifts(trips: list[tuple[float, float, float]], rate: float) -> None:
    now = 0.0
    bounds: ClockBounds | None = None
    for pause, trip, share in trips:
        sent = now + pause
        now = sent + trip
        read = sent + share * trip
        latest = ClockBounds.of(sent, now, stamp=(1.0 + rate) * read + 40.0)
        bounds = latest if bounds is None else bounds.narrowed(latest)
        assert bounds.least - 1e-9 <= read - ((1.0 + rate) * read + 40.0) <= bounds.most + 1e-9
        assert bounds.error <= latest.error + 1e-9


def test_bounds_that_contradict_earlier_ones_replace_them() -> None:
    later = ClockBounds.of(sent=20.0, received=20.5, stamp=90.0)
    assert ClockBounds.of(sent=10.0, received=10.5, stamp=2.0).narrowed(later) is later


class Old(DivertingStation):
    """A controller that has no diversions, or whose program that has them does not run yet."""

    started = False

    def shown(self) -> DiversionReply:
        if not self.started:
            raise MissingPartError("the version of its diversions is 0")
        return self.reply


def test_a_controller_without_diversions_is_named() -> None:
    device = Old().device()
    for ask in (device.reading, device.health, device.stop, lambda: device.diversion("any", boot_id="1")):
        with pytest.raises(CellError, match=r"\bno diversions\b.*\bfieldbus\.md\b.*\badd them\b") as error:
            ask()
        assert not isinstance(error.value, CommandError), "to repeat it is of no use"


def test_a_controller_whose_program_has_not_started_again_is_asked_again() -> None:
    station = Old()
    station.started = True
    device = station.device()
    assert device.health().ready
    station.started = False
    with pytest.raises(CommandError, match=r"\bcannot be asked\b.*\bversion\b") as error:
        station.divert(device, "early", 1)
    assert error.value.outcome is Outcome.NOT_DONE
    station.started = True
    assert station.divert(device, "early", 1).state is Diversion.QUEUED


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"coordinate": float("nan")}, r"\bcoordinate is nan\b"),
        ({"coordinate": 1e13}, r"\bcoordinate is 10000000000000\.0\b"),
        ({"number": -1}, r"\bobject is -1\b.*\b0 to\b"),
        ({"label": 2**31}, r"\bbin is 2147483648\b"),
        ({"boot_id": "yesterday"}, r"\bboot_id is 'yesterday'"),
        ({"timeout": 0.0}, r"\btimeout is 0\.0\b"),
    ],
)
def test_a_diversion_without_sense_is_not_sent(wrong: dict[str, object], said: str) -> None:
    station = DivertingStation()
    order = {"number": 1, "coordinate": 0.0, "label": 0, "boot_id": station.boot_id} | wrong
    with pytest.raises(CommandError, match=said) as error:
        station.device().divert("id", **order)  # type: ignore[arg-type] # the mistake
    assert error.value.outcome is Outcome.NOT_DONE
    assert station.connections == 0


GOOD = {
    **dict.fromkeys(("version", "boot"), 1),
    **dict.fromkeys(("sequence", "verb", "key", "phase", "reason", "position", "stamp"), 0),
    **dict.fromkeys(("flags", "queued", "forgotten"), 0),
}


@pytest.mark.parametrize(
    "garbage", [{"phase": 5}, {"reason": 2}, {"boot": 0}, {"flags": 4}, {"version": 22389}, {"stamp": -1}]
)
def test_garbage_is_told(garbage: dict[str, int]) -> None:
    assert checked_diversion(**GOOD, bins=()).boot == 1
    with pytest.raises(GarbageError, match=f" is {next(iter(garbage.values()))}, expected"):
        checked_diversion(**GOOD | garbage, bins=())
    with pytest.raises(MissingPartError):
        checked_diversion(**GOOD | {"version": 0}, bins=())
