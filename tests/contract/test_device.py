"""What the client does with connections that fail at the worst moment; no network, no process."""

from contextlib import suppress
from dataclasses import fields

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.fieldbus import FieldbusDevice
from beltsort.drivers.fieldbus.wire import COMMANDS, Reply, Request, Verb, checked
from beltsort.testing.controller import Controller, Machine
from tests.contract.station import Station

NOW = 1000.0
"""The cell's clock."""


class SortingStation(Station[Request, Reply]):
    """A controller of a belt that stops, whose replies may be garbage."""

    acting = COMMANDS

    def __init__(self, machine: Machine | None = None, garbage: dict[str, int] | None = None) -> None:
        super().__init__()
        self.time = 0.0
        self.garbage = garbage or {}
        machine = machine or Machine(sort_seconds=0.0, advance_seconds=0.0)
        self.controller: Controller = Controller(machine, boot=1, clock=lambda: self.time)
        self.controller.home(0)
        self.reply = self.controller.answer(Request(0, Verb.LOOK))

    def fresh(self) -> None:
        self.garbage = {}

    def shown(self) -> Reply:
        whole = {field.name: getattr(self.reply, field.name) for field in fields(Reply)}
        flags = whole.pop("ready") + 2 * whole.pop("emergency_stop")
        return checked(**whole | {"flags": flags} | self.garbage)

    @property
    def bins(self) -> tuple[int, ...]:
        return self.controller.answer(Request(self.controller.sequence, Verb.LOOK)).bins

    def device(self) -> FieldbusDevice:
        return FieldbusDevice(self.connect, "the station", answer_timeout=1.0, clock=lambda: NOW)


def lost_sort(station: SortingStation, device: FieldbusDevice) -> None:
    """Send the command "sort", which the network holds back."""
    station.holding = True
    with pytest.raises(CommandError, match=r"\bsort\w*\b.*Error\b") as error:
        device.sort(2, "sort")
    assert error.value.outcome is Outcome.UNKNOWN
    assert station.commands == 1
    station.holding = False


def test_a_command_that_is_late_after_the_question_never_acts() -> None:
    station = SortingStation()
    device = station.device()
    lost_sort(station, device)
    assert device.outcome_of("sort") is Outcome.NOT_DONE
    station.deliver()
    assert sum(station.bins) == 0
    device.sort(2, "sort")
    assert station.bins == (0, 0, 1, 0, 0)


def test_a_command_that_is_late_before_the_question_acts() -> None:
    station = SortingStation()
    device = station.device()
    lost_sort(station, device)
    station.deliver()
    assert device.outcome_of("sort") is Outcome.DONE
    device.sort(2, "sort")
    assert station.bins == (0, 0, 1, 0, 0)


@pytest.mark.slow
@pytest.mark.parametrize("unanswered", [1, 2, 3])
def test_requests_that_act_unanswered_do_not_block_the_next(unanswered: int) -> None:
    station = SortingStation()
    device = station.device()
    device.advance_to(1, "advance")
    station.silent = unanswered
    for _ in range(2):
        with suppress(CommandError):
            device.sort(2, "sort")
    device.sort(2, "sort")
    assert station.bins == (0, 0, 1, 0, 0)


def test_a_connection_that_failed_is_not_used_again() -> None:
    station = SortingStation()
    device = station.device()
    lost_sort(station, device)
    failed = station.wire
    device.sort(2, "sort")
    assert failed.broken
    assert station.connections == 2


def test_a_connection_that_broke_between_commands_is_replaced() -> None:
    station = SortingStation()
    device = station.device()
    device.sort(1, "first")
    station.wire.broken = True
    device.advance_to(1, "second")
    assert (station.connections, station.commands) == (2, 2)


def test_a_command_that_may_have_been_forgotten_is_unknown_and_not_repeated() -> None:
    station = SortingStation(Machine(sort_seconds=0.0, advance_seconds=0.0, memory=2))
    device = station.device()
    lost_sort(station, device)
    for index in range(1, 4):
        device.advance_to(index, f"advance-{index}")
    assert device.outcome_of("sort") is Outcome.UNKNOWN
    with pytest.raises(CommandError, match=r"\bforgotten\b.*\banother command id\b") as error:
        device.sort(2, "sort")
    assert error.value.outcome is Outcome.UNKNOWN
    assert sum(station.bins) == 0


def test_what_an_earlier_program_sent_is_unknown_unless_the_controller_still_remembers_that_time() -> None:
    station = SortingStation(Machine(sort_seconds=0.0, advance_seconds=0.0, memory=2))
    device = station.device()
    boot_id = device.health().boot_id
    assert device.outcome_of("earlier") is Outcome.UNKNOWN, "who knows when it was sent?"
    assert device.outcome_of("earlier", "another") is Outcome.UNKNOWN, "the controller has restarted since"
    assert device.outcome_of("earlier", boot_id) is Outcome.NOT_DONE
    for index in range(1, 4):
        device.advance_to(index, f"advance-{index}")
    assert device.outcome_of("earlier", boot_id) is Outcome.UNKNOWN, "it may have been forgotten"


@pytest.mark.parametrize(
    "garbage", [{"phase": 22389}, {"flags": 22389}, {"boot": 0}, {"position": -7}, {"phase": 9, "boot": 0}]
)
def test_garbage_while_idle_is_gone_with_the_next_reply(garbage: dict[str, int]) -> None:
    station = SortingStation(garbage=garbage)
    device = station.device()
    device.advance_to(1, "advance")
    station.garbage = garbage
    device.sort(2, "sort")
    assert station.bins == (0, 0, 1, 0, 0)
    station.wire.broken, station.garbage = True, garbage
    assert device.health().ready


def test_garbage_in_every_reply_is_told_as_garbage() -> None:
    class Mad(SortingStation):
        def take(self, request: Request) -> None:
            super().take(request)
            self.garbage = {"phase": 22389}

    with pytest.raises(CommandError, match=r"\bgarbage\b.*\bphase is 22389\b.*\b0 to 4\b"):
        Mad().device().health()


def test_an_answer_to_somebody_else_is_not_taken_for_ones_own() -> None:
    station = SortingStation()
    device = station.device()
    device.sort(0, "sort")
    station.take(Request(station.controller.sequence + 1, Verb.RECALL, key=7))
    device.advance_to(1, "advance")
    assert device.outcome_of("advance") is Outcome.DONE
    assert (station.connections, station.commands) == (2, 2)


def test_the_time_of_a_stop_is_on_the_cells_clock() -> None:
    station = SortingStation()
    device = station.device()
    assert device.advance_to(1, "advance") == NOW
    station.time += 5.0
    assert device.advance_to(1, "advance") == NOW - 5.0


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan"), float("inf")])
def test_a_timeout_is_a_number_of_seconds(timeout: float) -> None:
    station = SortingStation()
    with pytest.raises(CommandError, match=rf"\btimeout\b.* {timeout}\b.*\b0\b") as error:
        station.device().sort(0, "sort", timeout=timeout)
    assert error.value.outcome is Outcome.NOT_DONE
    assert station.connections == 0
