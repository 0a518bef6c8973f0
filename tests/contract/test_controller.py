"""The reference controller keeps its rules, whatever it is asked."""

from dataclasses import dataclass, field

from hypothesis import given
from hypothesis import strategies as st

from beltsort.cell.protocols import NOWHERE
from beltsort.drivers.fieldbus.wire import COMMANDS, Phase, Reason, Reply, Request, Verb, following
from beltsort.testing.controller import AdvanceFault, Controller, Machine
from tests.laws import cases

MACHINE = Machine(bins=3, capacity=4, advance_seconds=1.0, sort_seconds=1.0, memory=1000)

orders = st.tuples(
    st.sampled_from(Verb), st.integers(-1, 3), st.integers(1, 4), st.floats(0.0, 2.0), st.booleans()
)
"""Verb, target, key, seconds until it comes, whether the emergency stop is pressed and released before."""


@dataclass
class Rig:
    machine: Machine = MACHINE
    time: float = 0.0
    replies: list[Reply] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.controller = Controller(self.machine, boot=9, clock=lambda: self.time)
        self.controller.home(0)

    def ask(self, verb: Verb, target: int = 0, key: int = 0) -> Reply:
        request = Request(following(self.controller.sequence), verb, target, key)
        assert self.controller.is_new(request)
        self.replies.append(self.controller.answer(request))
        assert not self.controller.is_new(request)
        return self.replies[-1]


@cases(200)
@given(st.lists(orders, max_size=30))
def test_every_id_acts_at_most_once(script: list[tuple[Verb, int, int, float, bool]]) -> None:
    rig = Rig()
    verbs: dict[int, Verb] = {}
    for verb, target, key, seconds, pressed in script:
        rig.time += seconds
        if pressed:
            rig.controller.press()
            rig.controller.release()
        if rig.ask(verb, target, key).phase is Phase.RUNNING and verb in COMMANDS:
            verbs.setdefault(key, verb)
    rig.time += 10.0
    done = [verb for key, verb in verbs.items() if rig.ask(Verb.RECALL, key=key).phase is Phase.DONE]
    assert sum(rig.ask(Verb.LOOK).bins) == done.count(Verb.SORT)


@cases(200)
@given(st.lists(orders.filter(lambda order: order[0] is not Verb.HOME), max_size=30))
def test_the_belt_never_goes_back(script: list[tuple[Verb, int, int, float, bool]]) -> None:
    rig = Rig()
    for verb, target, key, seconds, _ in script:
        rig.time += seconds
        rig.ask(verb, target, key)
    positions = [reply.position for reply in rig.replies if reply.position != NOWHERE]
    assert positions == sorted(positions)


@cases(100)
@given(st.lists(orders, max_size=30))
def test_what_is_over_stays_as_it_is(script: list[tuple[Verb, int, int, float, bool]]) -> None:
    rig = Rig()
    over: dict[int, Phase] = {}
    for verb, target, key, seconds, _ in script:
        rig.time += seconds
        reply = rig.ask(verb, target, key)
        if verb in (*COMMANDS, Verb.RECALL) and reply.reason is not Reason.OTHER_COMMAND:
            assert reply.phase is over.get(key, reply.phase)
            if reply.phase in (Phase.DONE, Phase.BROKEN_OFF):
                over[key] = reply.phase


def test_late_requests_are_ignored() -> None:
    rig = Rig()
    late = Request(following(rig.controller.sequence), Verb.SORT, 0, 5)
    rig.ask(Verb.RECALL, key=5)
    assert not rig.controller.is_new(late)


def test_memory_is_bounded_and_says_so() -> None:
    rig = Rig(Machine(memory=3, advance_seconds=0.0))
    for index in range(1, 6):
        reply = rig.ask(Verb.ADVANCE, index, key=index)
    assert (reply.remembered, reply.forgotten) == (3, 2)
    assert rig.ask(Verb.RECALL, key=2).phase is Phase.FORGOTTEN
    assert rig.ask(Verb.RECALL, key=3).phase is Phase.DONE


def test_a_delayed_command_is_running_before_it_moves_and_only_one_is_delayed() -> None:
    rig = Rig()
    rig.controller.delay(4.0)
    rig.ask(Verb.ADVANCE, 4, key=1)
    rig.time += 3.5
    assert rig.ask(Verb.RECALL, key=1).phase is Phase.RUNNING
    rig.ask(Verb.STOP)
    rig.ask(Verb.HOME, 0)
    rig.ask(Verb.ADVANCE, 1, key=2)
    rig.time += 1.0
    assert rig.ask(Verb.RECALL, key=2).phase is Phase.DONE


def test_a_belt_stopped_on_the_way_goes_on_from_there() -> None:
    rig = Rig()
    rig.ask(Verb.ADVANCE, 4, key=1)
    rig.time += 1.5
    rig.ask(Verb.STOP)
    assert rig.ask(Verb.RECALL, key=1).reason is Reason.STOPPED
    assert rig.ask(Verb.ADVANCE, 1, key=2).reason is Reason.BACKWARDS
    assert rig.ask(Verb.LOOK).position == NOWHERE
    assert rig.ask(Verb.ADVANCE, 4, key=3).phase is Phase.RUNNING
    rig.time += 3.0
    assert rig.ask(Verb.LOOK).position == 4


def test_a_command_that_was_broken_off_never_acts_again() -> None:
    rig = Rig()
    rig.ask(Verb.SORT, 1, key=1)
    rig.time += 0.5
    rig.ask(Verb.STOP)
    again = rig.ask(Verb.SORT, 1, key=1)
    assert (again.phase, again.reason, again.age) == (Phase.BROKEN_OFF, Reason.STOPPED, 0)
    rig.time += 2.0
    reply = rig.ask(Verb.RECALL, key=1)
    assert (reply.age, sum(reply.bins)) == (2000, 0)
    assert rig.ask(Verb.SORT, 1, key=2).phase is Phase.RUNNING


def test_a_fault_lasts_until_somebody_has_looked() -> None:
    rig = Rig()
    rig.controller.inject(AdvanceFault.OVERSHOT)
    rig.ask(Verb.ADVANCE, 1, key=1)
    rig.time += 1.0
    assert rig.ask(Verb.RECALL, key=1).reason is Reason.OVERSHOT
    assert not rig.ask(Verb.LOOK).ready
    assert rig.ask(Verb.ADVANCE, 3, key=2).reason is Reason.OVERSHOT
    rig.ask(Verb.HOME, 2)
    assert rig.ask(Verb.ADVANCE, 3, key=2).phase is Phase.RUNNING


def test_an_unknown_verb_is_refused() -> None:
    rig = Rig()
    reply = rig.controller.answer(Request(1, 99))
    assert (reply.phase, reply.reason) == (Phase.NOT_DONE, Reason.NO_SUCH_VERB)
