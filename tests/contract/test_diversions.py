"""Laws of belts that never stop, whatever fails: each object is diverted once, and what is told is true."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from itertools import count

import numpy as np
import pytest

from beltsort.cell import BeltReading, CommandError, Diversion, DiversionStatus, Outcome
from tests.account import Account
from tests.contract.bench import new_id
from tests.contract.diverting_peers import DIVERTERS, PEERS, SPEED, DivertingPeer
from tests.contract.peer import PATIENCE
from tests.contract.ros2_diverter_peer import Ros2DiverterPeer
from tests.waiting import wait_until

pytestmark = pytest.mark.process

NUMBERS = count()
NEAR = 0.6
"""Metres before the mark of an object that is diverted soon: a diversion has more than a second."""
FARTHER = 3.0
"""Metres before the mark of an object that is diverted after some faults."""
FAR = 6.0
"""Metres before the mark of an object that is on its way for the whole test."""
FAULTS = ("lose", "cut", "hang", "kill", "slow", "press", "fill")
APART = 0.05
"""Metres between two objects, at least."""


class BeltBench:
    """A belt that never stops, one client, and the objects of a test."""

    def __init__(self, peer: DivertingPeer, account: Account) -> None:
        self.peer = peer
        self.device = peer.device()
        self._account = account
        self._taken: list[tuple[str, float]] = []
        self.orders: dict[str, tuple[int, int]] = {}

    def suffers(self) -> None:
        """Note that a fault is being injected."""
        self._account.injected(self.peer.name)

    def reading(self) -> BeltReading:
        return wait_until(self._reading, "the belt can be read")

    def _reading(self) -> BeltReading | None:
        try:
            return self.device.reading(timeout=PATIENCE)
        except CommandError:
            return None

    def order(self, ahead: float, label: int = 0) -> dict[str, object]:
        """Return the diversion of a new object that is so far before the mark now."""
        reading = self.reading()
        coordinate = reading.travel + ahead
        while any(boot == reading.boot_id and abs(coordinate - taken) < APART for boot, taken in self._taken):
            coordinate += APART
        self._taken.append((reading.boot_id, coordinate))
        return {
            "number": next(NUMBERS),
            "coordinate": coordinate,
            "label": label,
            "boot_id": reading.boot_id,
        }

    def divert(self, command_id: str, order: dict[str, object], timeout: float = PATIENCE) -> DiversionStatus:
        self.orders[command_id] = (int(str(order["number"])), int(str(order["label"])))
        return self.device.divert(command_id, **order, timeout=timeout)  # type: ignore[arg-type] # fields of one order

    def tried(self, command_id: str, order: dict[str, object], timeout: float) -> Diversion:
        """Return what is known about a diversion after it was sent once."""
        try:
            return self.divert(command_id, order, timeout).state
        except CommandError as error:
            return Diversion.UNKNOWN if error.outcome is Outcome.UNKNOWN else Diversion.NOT_DONE

    def queued(self, ahead: float, label: int = 0) -> tuple[str, dict[str, object]]:
        """Queue the diversion of a new object; on a busy machine some come too late."""
        while True:
            command_id, order = new_id(), self.order(ahead, label)
            status = self.divert(command_id, order)
            if status.state is not Diversion.TOO_LATE:
                assert status == DiversionStatus(Diversion.QUEUED, str(order["boot_id"]))
                return command_id, order
            ahead *= 2.0

    def settled(self, command_id: str, boot_id: object) -> Diversion:
        """Return the final state of a diversion."""

        def told() -> Diversion | None:
            try:
                state = self.device.diversion(command_id, boot_id=str(boot_id), timeout=PATIENCE).state
            except CommandError:
                return None
            return state if state.final else None

        return wait_until(told, f"the end of {command_id}")

    def ends(self, order: dict[str, object]) -> list[tuple[int, str]]:
        """Return the bins and phases in which an object has ended."""
        return [(end.bin, end.phase) for end in self.peer.ended() if end.object == order["number"]]

    def check(self, order: dict[str, object], *ends: tuple[int, str]) -> None:
        """Check what was really done with an object."""
        ended = self.ends(order)
        self._account.lost(self.peer.name, abs(len(ended) - len(ends)))
        assert ended == list(ends)


@pytest.fixture(scope="module", params=(*PEERS, Ros2DiverterPeer), ids=lambda kind: kind.name)
def peer(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[DivertingPeer]:
    with ExitStack() as stack:
        peer = request.param(tmp_path_factory.mktemp("belt") / "peer")
        stack.callback(peer.close)
        yield peer


@pytest.fixture
def belt(peer: DivertingPeer, account: Account) -> BeltBench:
    peer.refresh()
    return BeltBench(peer, account)


def test_an_object_is_diverted_into_its_bin_and_no_repetition_diverts_it_again(belt: BeltBench) -> None:
    command_id, order = belt.queued(NEAR, label=1)
    belt.suffers()
    assert belt.divert(command_id, order).state in (Diversion.QUEUED, Diversion.DONE)
    assert belt.settled(command_id, order["boot_id"]) is Diversion.DONE
    belt.suffers()
    assert belt.divert(command_id, order).state is Diversion.DONE
    belt.suffers()
    assert belt.divert(new_id(), order).state is Diversion.NOT_DONE
    belt.check(order, (1, "DONE"))


def test_one_that_comes_too_late_is_told_and_never_diverted(belt: BeltBench) -> None:
    command_id, order = new_id(), belt.order(-1.0)
    belt.suffers()
    for _ in range(2):
        assert belt.divert(command_id, order).state is Diversion.TOO_LATE
    assert belt.settled(command_id, order["boot_id"]) is Diversion.TOO_LATE
    belt.check(order, (0, "TOO_LATE"))


def test_a_lost_reply_does_not_undo_the_diversion(belt: BeltBench) -> None:
    command_id, order = new_id(), belt.order(FARTHER)
    belt.device.reading()
    belt.suffers()
    belt.peer.push("lose")
    assert belt.tried(command_id, order, timeout=1.5) in (Diversion.QUEUED, Diversion.UNKNOWN)
    assert belt.divert(command_id, order).state in (Diversion.QUEUED, Diversion.DONE)
    assert belt.settled(command_id, order["boot_id"]) is Diversion.DONE
    belt.check(order, (0, "DONE"))


def test_the_queue_is_carried_out_while_the_client_is_away(belt: BeltBench) -> None:
    command_id, order = belt.queued(NEAR, label=2)
    belt.suffers()
    belt.peer.cut()
    belt.device.close()
    wait_until(lambda: belt.ends(order), "the object is diverted")
    belt.check(order, (2, "DONE"))
    another = belt.peer.device()
    assert another.diversion(command_id, boot_id=str(order["boot_id"])).state is Diversion.DONE


def test_a_connection_that_was_dropped_is_replaced(belt: BeltBench) -> None:
    command_id, order = belt.queued(FARTHER)
    kept = (Diversion.QUEUED, Diversion.DONE)
    for _ in range(3):
        belt.suffers()
        belt.peer.cut()
        assert belt.divert(command_id, order).state in kept
    belt.suffers()
    belt.peer.cut()
    assert belt.device.diversion(command_id, boot_id=str(order["boot_id"])).state in kept
    assert belt.settled(command_id, order["boot_id"]) is Diversion.DONE
    belt.check(order, (0, "DONE"))


def test_a_slow_network_makes_the_time_of_a_reading_less_certain_but_not_wrong(belt: BeltBench) -> None:
    near = belt.reading()
    belt.device = belt.peer.device()
    belt.suffers()
    belt.peer.slow(0.05)
    try:
        far = belt.reading()
    finally:
        belt.peer.slow(0.0)
    assert far.error > 0.02
    assert far.boot_id == near.boot_id
    expected = near.travel + SPEED * (far.stamp - near.stamp)
    assert abs(far.travel - expected) <= SPEED * (near.error + far.error) + 1e-4


def test_after_a_restart_nothing_is_done_that_was_queued_before(belt: BeltBench) -> None:
    done, first = belt.queued(NEAR)
    assert belt.settled(done, first["boot_id"]) is Diversion.DONE
    command_id, order = belt.queued(FAR)
    belt.suffers()
    belt.peer.kill()
    with pytest.raises(CommandError) as error:
        belt.device.diversion(command_id, boot_id=str(order["boot_id"]), timeout=0.5)
    assert error.value.outcome is Outcome.UNKNOWN
    belt.peer.restart()
    assert belt.reading().boot_id != order["boot_id"]
    for known in (command_id, done):
        status = belt.device.diversion(known, boot_id=str(order["boot_id"]))
        assert (status.state, status.retry) == (Diversion.UNKNOWN, False)
    status = belt.divert(command_id, order)
    assert (status.state, status.retry) == (Diversion.UNKNOWN, False)
    following, later = belt.queued(NEAR)
    assert belt.settled(following, later["boot_id"]) is Diversion.DONE
    belt.check(order)
    belt.check(first, (0, "DONE"))


def test_a_controller_that_hangs_is_told_and_what_it_did_is_the_truth(belt: BeltBench) -> None:
    command_id, order = belt.queued(FARTHER)
    late, other = new_id(), belt.order(FAR)
    belt.suffers()
    belt.peer.hang()
    try:
        with pytest.raises(CommandError) as error:
            belt.device.diversion(command_id, boot_id=str(order["boot_id"]), timeout=0.5)
        assert error.value.outcome is Outcome.UNKNOWN
        with pytest.raises(CommandError) as error:
            belt.divert(late, other, timeout=0.5)
        assert error.value.outcome is Outcome.NOT_DONE
    finally:
        belt.peer.resume()
    assert belt.divert(late, other).state is Diversion.QUEUED
    assert belt.settled(command_id, order["boot_id"]) is Diversion.DONE
    belt.check(order, (0, "DONE"))


def test_what_is_refused_may_be_sent_again_when_the_reason_has_passed(belt: BeltBench) -> None:
    command_id, order = new_id(), belt.order(FAR)
    for fault, remedy in (("press", "release"), ("fill", "empty")):
        belt.suffers()
        belt.peer.push(fault)
        status = belt.divert(command_id, order)
        assert (status.state, status.retry) == (Diversion.NOT_DONE, True)
        assert status.reason
        belt.peer.push(remedy)
    belt.peer.push("start")
    assert belt.divert(command_id, order).state is Diversion.QUEUED


def test_no_fault_diverts_an_object_twice_or_makes_a_lie(belt: BeltBench) -> None:
    check_under_faults(belt, np.random.default_rng(5), FAULTS)


@pytest.mark.soak
def test_nor_do_many_faults_in_any_order(belt: BeltBench) -> None:
    for seed in range(100, 110):
        rng = np.random.default_rng(seed)
        check_under_faults(belt, rng, [str(fault) for fault in rng.choice(FAULTS, 12)])


def check_under_faults(belt: BeltBench, rng: np.random.Generator, faults: Sequence[str]) -> None:
    """Divert objects while faults befall the controller, and compare what is told with what was done."""
    told: dict[str, tuple[dict[str, object], Diversion]] = {}
    for fault in faults:
        ids = [new_id() for _ in range(3)]
        orders = [
            belt.order(float(rng.uniform(0.0, 2.0)), label=int(rng.integers(len(DIVERTERS)))) for _ in ids
        ]
        belt.suffers()
        hurt(belt.peer, fault)
        for command_id, order in zip(ids, orders, strict=True):
            told[command_id] = order, belt.tried(command_id, order, timeout=0.3)
        mend(belt.peer, fault)
        for command_id, order in zip(ids, orders, strict=True):
            if told[command_id][1] is Diversion.UNKNOWN:
                told[command_id] = order, belt.divert(command_id, order).state
    for command_id, (order, state) in told.items():
        if state is Diversion.QUEUED:
            status = wait_until(lambda: final(belt, command_id, order), "the end, or a restart")  # noqa: B023 - it is called in this turn of the loop
            state = status.state
        label, ends = order["label"], belt.ends(order)
        if state is Diversion.DONE:
            assert ends == [(label, "DONE")]
        elif state is not Diversion.UNKNOWN:
            assert (label, "DONE") not in ends
    done = Counter(end.object for end in belt.peer.ended() if end.phase == "DONE")
    assert set(done.values()) == {1}


def final(belt: BeltBench, command_id: str, order: dict[str, object]) -> DiversionStatus | None:
    """Return what became of a diversion, unknown if the controller has been restarted since."""
    status = belt.device.diversion(command_id, boot_id=str(order["boot_id"]), timeout=PATIENCE)
    return status if status.state.final or status.boot_id != order["boot_id"] else None


def hurt(peer: DivertingPeer, fault: str) -> None:
    match fault:
        case "slow":
            peer.slow(0.1)
        case "lose" | "press" | "fill":
            peer.push(fault)
        case "kill":
            peer.kill()
            peer.restart()
        case _:
            getattr(peer, fault)()


def mend(peer: DivertingPeer, fault: str) -> None:
    match fault:
        case "slow":
            peer.slow(0.0)
        case "hang":
            peer.resume()
        case "press":
            peer.push("release")
            peer.push("start")
        case "fill":
            peer.push("empty")
