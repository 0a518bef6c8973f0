"""The reference controller of a belt that never stops keeps its rules, whatever it is asked."""

import re
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.drivers.fieldbus.diversions import (
    DIVERSION_EXPLANATIONS,
    DiversionPhase,
    DiversionReason,
    DiversionReply,
    DiversionRequest,
    DiversionVerb,
)
from beltsort.drivers.fieldbus.wire import following
from beltsort.testing.diverting import DivertingController, DivertingMachine
from tests.laws import cases

PAGE = (Path(__file__).parents[2] / "docs" / "fieldbus.md").read_text()
MACHINE = DivertingMachine(
    diverters=(100, 200), speed=10, lead=10, window=3, capacity=3, queue=4, memory=1000
)

orders = st.tuples(
    st.integers(1, 5),
    st.integers(0, 5),
    st.integers(-1, 2),
    st.floats(0.0, 8.0),
    st.sampled_from(["", "press", "release", "start", "stop", "fill"]),
)
"""Key, object, bin, seconds until it comes, what happens before."""


@dataclass
class Rig:
    machine: DivertingMachine = MACHINE
    boot: int = 9
    time: float = 0.0
    replies: list[DiversionReply] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.controller = DivertingController(self.machine, self.boot, clock=lambda: self.time)

    def ask(self, verb: DiversionVerb, key: int = 0, **order: int) -> DiversionReply:
        request = DiversionRequest(following(self.controller.sequence), verb, key, **order)
        assert self.controller.is_new(request)
        self.replies.append(self.controller.answer(request))
        assert not self.controller.is_new(request)
        return self.replies[-1]

    def divert(self, key: int, number: int, bin_: int, boot: int = 9) -> DiversionReply:
        return self.ask(DiversionVerb.DIVERT, key, object=number, coordinate=10 * number, bin=bin_, boot=boot)

    def outcome(self, key: int) -> tuple[DiversionPhase, DiversionReason]:
        reply = self.ask(DiversionVerb.RECALL, key)
        return reply.phase, reply.reason


@cases(200)
@given(st.lists(orders, max_size=30))
def test_no_object_is_in_two_bins_and_every_accepted_one_is_told(
    script: list[tuple[int, int, int, float, str]],
) -> None:
    rig = Rig()
    objects: dict[int, int] = {}
    ended: dict[int, DiversionPhase] = {}
    filled = False
    for key, number, bin_, seconds, before in script:
        rig.time += seconds
        if before == "stop":
            rig.ask(DiversionVerb.STOP)
        elif before:
            filled |= before == "fill"
            getattr(rig.controller, before)()
        reply = rig.divert(key, number, bin_)
        if reply.phase in (DiversionPhase.QUEUED, DiversionPhase.TOO_LATE):
            assert objects.setdefault(key, number) == number
        for known in objects:
            phase, _ = rig.outcome(known)
            assert ended.get(known, phase) is phase
            if phase is not DiversionPhase.QUEUED:
                ended[known] = phase
    rig.controller.release()
    rig.controller.start()
    rig.time += 100.0
    phases = {key: rig.outcome(key)[0] for key in objects}
    assert len(set(objects.values())) == len(objects)
    assert all(phase not in (DiversionPhase.UNKNOWN, DiversionPhase.QUEUED) for phase in phases.values())
    if not filled:
        done = list(phases.values()).count(DiversionPhase.DONE)
        assert sum(rig.ask(DiversionVerb.LOOK).bins) == done


def test_an_object_is_diverted_when_it_comes_by() -> None:
    rig = Rig()
    assert rig.divert(1, 0, 0).phase is DiversionPhase.QUEUED
    rig.time = 9.9
    assert rig.outcome(1)[0] is DiversionPhase.QUEUED
    rig.time = 10.0
    assert rig.outcome(1)[0] is DiversionPhase.DONE
    assert rig.replies[-1].bins == (1, 0)
    assert (rig.replies[-1].position, rig.replies[-1].stamp) == (100, 10_000_000)


def test_polls_between_two_counts_of_the_encoder_lose_none() -> None:
    rig = Rig()
    for _ in range(1000):
        rig.time += 0.01
        rig.ask(DiversionVerb.LOOK)
    assert rig.replies[-1].position == 100


def test_the_same_key_never_diverts_twice() -> None:
    rig = Rig()
    rig.divert(1, 0, 0)
    rig.time = 20.0
    assert rig.divert(1, 0, 0).phase is DiversionPhase.DONE
    assert rig.divert(1, 0, 1).reason is DiversionReason.OTHER_COMMAND
    assert rig.divert(2, 0, 1).reason is DiversionReason.ALREADY_DIVERTED
    assert rig.replies[-1].bins == (1, 0)


def test_an_object_under_another_number_is_recognised_by_its_coordinate() -> None:
    rig = Rig()
    rig.divert(1, 0, 0)
    reply = rig.ask(DiversionVerb.DIVERT, 2, object=7, coordinate=3, bin=1, boot=9)
    assert reply.reason is DiversionReason.ALREADY_DIVERTED
    assert rig.ask(DiversionVerb.DIVERT, 3, object=7, coordinate=4, bin=1, boot=9).queued == 2


@pytest.mark.parametrize(("seconds", "phase"), [(9.0, DiversionPhase.QUEUED), (9.1, DiversionPhase.TOO_LATE)])
def test_after_the_last_moment_it_is_too_late(seconds: float, phase: DiversionPhase) -> None:
    rig = Rig(time=0.0)
    rig.time = seconds
    assert rig.divert(1, 0, 0).phase is phase
    rig.time = 50.0
    late = phase is DiversionPhase.TOO_LATE
    assert rig.divert(1, 0, 0).phase is (phase if late else DiversionPhase.DONE)
    assert rig.replies[-1].bins == ((0, 0) if late else (1, 0))


def test_queued_diversions_count_for_the_bin_and_for_the_queue() -> None:
    rig = Rig()
    assert [rig.divert(key, key, 0).reason.name for key in range(1, 5)] == ["NONE"] * 3 + ["BIN_FULL"]
    assert rig.divert(4, 4, 1).phase is DiversionPhase.QUEUED
    assert rig.divert(5, 5, 1).reason is DiversionReason.QUEUE_FULL
    rig.time = 13.0
    assert rig.divert(5, 5, 1).phase is DiversionPhase.QUEUED


def test_a_bin_filled_meanwhile_is_told() -> None:
    rig = Rig()
    rig.divert(1, 0, 0)
    rig.controller.fill()
    rig.time = 10.0
    assert rig.outcome(1) == (DiversionPhase.NOT_DONE, DiversionReason.BIN_FULL)
    rig.controller.empty()
    assert rig.divert(1, 0, 0).reason is DiversionReason.BIN_FULL


def test_a_stop_keeps_the_queue() -> None:
    rig = Rig()
    rig.divert(1, 0, 0)
    rig.time = 5.0
    rig.ask(DiversionVerb.STOP)
    rig.time = 100.0
    assert rig.outcome(1)[0] is DiversionPhase.QUEUED
    rig.controller.start()
    rig.time = 105.0
    assert rig.outcome(1)[0] is DiversionPhase.DONE


def test_an_object_that_coasts_past_during_an_emergency_stop_is_told() -> None:
    rig = Rig()
    rig.divert(1, 0, 0)
    rig.divert(2, 2, 0)
    rig.time = 9.5
    rig.controller.press(coasting=10)
    assert rig.divert(3, 4, 0).reason is DiversionReason.EMERGENCY_STOP
    rig.controller.start()
    assert not rig.ask(DiversionVerb.LOOK).moving
    rig.controller.release()
    rig.controller.start()
    rig.time = 20.0
    assert rig.outcome(1) == (DiversionPhase.NOT_DONE, DiversionReason.EMERGENCY_STOP)
    assert rig.outcome(2)[0] is DiversionPhase.DONE


def test_after_a_restart_no_coordinate_of_before_is_used() -> None:
    Rig().divert(1, 0, 0)
    restarted = Rig(boot=10)
    assert restarted.outcome(1)[0] is DiversionPhase.UNKNOWN
    assert restarted.divert(1, 0, 0, boot=9).reason is DiversionReason.OTHER_BOOT
    assert restarted.ask(DiversionVerb.LOOK).queued == 0


def test_only_ended_diversions_are_forgotten() -> None:
    rig = Rig(DivertingMachine((100, 200), speed=10, lead=10, window=3, memory=1))
    for key in (1, 2, 3):
        rig.divert(key, key, 0)
    rig.divert(4, 9, 1)
    rig.time = 14.0
    assert [rig.outcome(key)[0].name for key in (1, 2, 3, 4)] == ["UNKNOWN", "UNKNOWN", "DONE", "QUEUED"]
    assert rig.replies[-1].forgotten == 2


@pytest.mark.parametrize("kind", [DiversionVerb, DiversionPhase, DiversionReason])
def test_the_page_has_the_numbers_of_the_code(kind: type[IntEnum]) -> None:
    section = PAGE.split("## A belt that never stops")[1].split("\n## ")[0]
    rows = set(re.findall(r"^\| `([A-Z_]+)` \| (\d+) \|", section, re.MULTILINE))
    assert {(member.name, str(member.value)) for member in kind if member.name != "NONE"} <= rows


def test_every_reason_is_explained() -> None:
    assert set(DIVERSION_EXPLANATIONS) == set(DiversionReason)
