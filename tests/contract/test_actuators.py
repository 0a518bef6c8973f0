"""What every arm, belt and sorter does with commands, and what becomes of those that fail."""

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.testing.fault_kinds import Fault
from tests.contract.bench import Bench, benches, error_of, new_id
from tests.contract.in_process import InProcessPeer
from tests.contract.peer import Peer, ProcessPeer
from tests.contract.peers import EVERY, IN_PROCESS, POSED, PROCESSES, REFUSING, ServerPeer
from tests.contract.ros_peer import Ros1Peer, Ros2Peer, RosPeer

pytestmark = pytest.mark.process


@benches(EVERY)
def test_a_command_is_done_when_it_returns(bench: Bench[Peer]) -> None:
    for command_id in (new_id(), new_id()):
        target = bench.peer.fresh(bench.role)
        expected = bench.after(target)
        bench.act(target, command_id)
        assert bench.outcome_of(command_id) is Outcome.DONE
        bench.check(expected)


@benches(EVERY)
def test_a_duplicate_command_acts_once(bench: Bench[Peer]) -> None:
    commands = []
    for command_id in (new_id(), new_id()):
        target = bench.peer.fresh(bench.role)
        expected = bench.after(target)
        commands.append((target, command_id))
        bench.act(target, command_id)
    for target, command_id in commands:
        bench.suffers()
        bench.act(target, command_id)
    bench.check(expected)


@benches(EVERY)
def test_an_id_belongs_to_one_command(bench: Bench[Peer]) -> None:
    command_id = new_id()
    target = bench.peer.fresh(bench.role)
    expected = bench.after(target)
    bench.act(target, command_id)
    bench.suffers()
    with pytest.raises(CommandError, match=r"\bid\b.*\bcommand\b") as error:
        bench.act(1 - target % 2 if bench.device_kind == "arm" else target + 1, command_id)
    assert error.value.outcome is Outcome.NOT_DONE
    assert bench.outcome_of(command_id) is Outcome.DONE
    bench.check(expected)


@benches(REFUSING)
def test_a_target_that_cannot_be_reached_moves_nothing(bench: Bench[Peer]) -> None:
    bench.act(bench.peer.fresh(bench.role), new_id())
    command_id, world = new_id(), bench.world
    bench.suffers()
    with pytest.raises(CommandError) as error:
        bench.act(bench.peer.impossible(bench.role), command_id)
    assert error.value.outcome is Outcome.NOT_DONE
    assert bench.outcome_of(command_id) is not Outcome.DONE
    bench.check(world)
    target = bench.peer.fresh(bench.role)
    expected = bench.after(target)
    bench.act(target, command_id)
    bench.check(expected)


@benches(EVERY)
def test_a_lost_acknowledgement_does_not_undo_the_act(bench: Bench[Peer]) -> None:
    command_id, target = new_id(), bench.peer.fresh(bench.role)
    expected = bench.after(target)
    bench.suffers()
    bench.peer.lose(bench.role)
    with pytest.raises(CommandError) as error:
        bench.act(target, command_id, timeout=2.5)
    assert error.value.outcome is Outcome.UNKNOWN
    bench.peer.heard()
    assert bench.settled(command_id) is Outcome.DONE
    bench.act(target, command_id)
    bench.check(expected)


@benches(EVERY, "sorter")
def test_a_full_bin_takes_nothing(bench: Bench[Peer]) -> None:
    command_id, target = new_id(), bench.peer.fresh(bench.role)
    bench.suffers()
    bench.peer.fill()
    with pytest.raises(CommandError, match="full") as error:
        bench.act(target, command_id)
    assert error.value.outcome is bench.outcome_of(command_id) is Outcome.NOT_DONE
    bench.peer.mend()
    expected = bench.after(target)
    bench.act(target, command_id)
    bench.check(expected)


@benches(PROCESSES, "belt")
def test_the_next_program_finds_the_belt_where_it_stands(bench: Bench[ProcessPeer]) -> None:
    target = bench.peer.fresh(bench.role)
    bench.act(target, new_id())
    peer = bench.peer
    following = peer.unhomed() if isinstance(peer, ServerPeer) else peer.ready(bench.role)
    assert not following.health().needs_home
    assert following.position() == target
    following.advance_to(target + 1, new_id())
    assert following.position() == bench.world == target + 1


@benches(PROCESSES)
def test_a_killed_peer_leaves_the_command_unsettled(bench: Bench[ProcessPeer]) -> None:
    earlier, command_id = new_id(), new_id()
    bench.act(bench.peer.fresh(bench.role), earlier)
    boot_id = bench.device.health().boot_id
    target = bench.peer.far(bench.role)
    moving = bench.begun(target, command_id, timeout=2.5)
    bench.suffers()
    bench.peer.kill()
    assert error_of(moving).outcome is Outcome.UNKNOWN
    bench.suffers()
    bench.peer.restart()
    assert bench.outcome_of(command_id) is not Outcome.DONE
    assert bench.outcome_of(earlier) is not Outcome.NOT_DONE
    bench.await_restart(boot_id)
    if bench.device_kind == "sorter" or not isinstance(bench.peer, RosPeer):
        world = bench.world
        with pytest.raises(CommandError, match=r"\bbefore\b.*\brestarted\b") as error:
            bench.act(target, command_id)
        assert error.value.outcome is Outcome.UNKNOWN
        bench.check(world)
    bench.peer.refresh()
    bench.device = bench.peer.ready(bench.role)
    target = bench.peer.fresh(bench.role)
    expected = bench.after(target)
    bench.act(target, new_id())
    bench.check(expected)


@benches(PROCESSES)
def test_a_late_answer_is_ignored_and_the_outcome_is_the_truth(bench: Bench[ProcessPeer]) -> None:
    command_id, target = new_id(), bench.peer.far(bench.role)
    expected = bench.after(target)
    moving = bench.begun(target, command_id, timeout=2.5)
    bench.suffers()
    bench.peer.hang()
    assert error_of(moving).outcome is Outcome.UNKNOWN
    bench.peer.resume()
    assert bench.settled(command_id) is Outcome.DONE
    bench.check(expected)
    target = bench.peer.fresh(bench.role)
    expected = bench.after(target)
    bench.act(target, new_id())
    bench.check(expected)


@benches(PROCESSES)
def test_a_peer_that_hangs_before_the_command_acts_at_most_once(bench: Bench[ProcessPeer]) -> None:
    bench.act(bench.peer.fresh(bench.role), new_id())
    command_id, target = new_id(), bench.peer.fresh(bench.role)
    expected = bench.after(target)
    bench.suffers()
    bench.peer.hang()
    with pytest.raises(CommandError) as error:
        bench.act(target, command_id, timeout=1.0)
    bench.peer.resume()
    if bench.device_kind in ("belt", "sorter"):
        assert error.value.outcome is bench.outcome_of(command_id) is Outcome.NOT_DONE
    bench.act(target, command_id)
    assert bench.outcome_of(command_id) is Outcome.DONE
    bench.check(expected)


@benches(PROCESSES, "belt")
def test_a_stuck_belt_is_not_said_to_have_moved(bench: Bench[ProcessPeer]) -> None:
    command_id, target = new_id(), bench.peer.fresh(bench.role)
    world = bench.world
    bench.suffers()
    bench.peer.stick()
    with pytest.raises(CommandError) as error:
        bench.act(target, command_id, timeout=4.0)
    assert error.value.outcome is bench.outcome_of(command_id)
    assert error.value.outcome is not Outcome.DONE
    bench.check(world)
    bench.peer.looked_at(world)
    bench.act(target, command_id)
    bench.check(target)


@benches(PROCESSES, "belt")
def test_a_belt_that_goes_too_far_says_where_it_is(bench: Bench[ProcessPeer]) -> None:
    command_id, target = new_id(), bench.peer.fresh(bench.role)
    bench.suffers()
    bench.peer.overshoot()
    with pytest.raises(CommandError, match=rf"\b{target + 1}\b") as error:
        bench.act(target, command_id, timeout=4.0)
    assert error.value.outcome is bench.outcome_of(command_id)
    assert error.value.outcome in (Outcome.BROKEN_OFF, Outcome.UNKNOWN)
    bench.check(target + 1)
    bench.peer.looked_at(target + 1)
    bench.act(target + 2, new_id())
    bench.check(target + 2)


@benches([Ros1Peer, Ros2Peer], "arm")
def test_an_arm_that_stops_elsewhere_says_so(bench: Bench[RosPeer]) -> None:
    command_id, target = new_id(), bench.peer.fresh(bench.role)
    bench.suffers()
    bench.peer.stray()
    with pytest.raises(CommandError, match=r"\bviewpoint 'p\d'.*\bexpected\b") as error:
        bench.act(target, command_id)
    assert error.value.outcome is bench.outcome_of(command_id) is Outcome.NOT_DONE
    bench.peer.mend()
    bench.act(target, command_id)
    bench.check(target)


@benches(POSED, "arm")
def test_an_arm_that_goes_elsewhere_unnoticed_shows_in_the_pose(bench: Bench[InProcessPeer]) -> None:
    target = bench.peer.fresh(bench.role)
    bench.suffers()
    bench.peer.fail(bench.role, Fault.WRONG_ARRIVAL)
    bench.act(target, new_id())
    assert bench.world != target
    bench.act(target, new_id())
    bench.check(target)


@benches(IN_PROCESS)
def test_a_late_act_happens_once_nobody_waits(bench: Bench[InProcessPeer]) -> None:
    command_id, target = new_id(), bench.peer.fresh(bench.role)
    expected = bench.after(target)
    bench.suffers()
    bench.peer.fail(bench.role, Fault.LATE)
    with pytest.raises(CommandError, match=r"\d s\b") as error:
        bench.act(target, command_id)
    assert error.value.outcome is Outcome.UNKNOWN
    assert bench.settled(command_id) is Outcome.DONE
    bench.act(target, command_id)
    bench.check(expected)


@benches(IN_PROCESS)
def test_a_restart_wipes_the_memory(bench: Bench[InProcessPeer]) -> None:
    earlier, command_id = new_id(), new_id()
    bench.act(bench.peer.fresh(bench.role), earlier)
    boot_id, target = bench.device.health().boot_id, bench.peer.fresh(bench.role)
    bench.suffers()
    bench.peer.fail(bench.role, Fault.RESTART)
    with pytest.raises(CommandError, match="restart") as error:
        bench.act(target, command_id)
    assert error.value.outcome is Outcome.UNKNOWN
    assert bench.device.health().boot_id != boot_id
    assert bench.outcome_of(earlier) is bench.outcome_of(command_id) is Outcome.UNKNOWN
    target = bench.peer.fresh(bench.role)
    expected = bench.after(target)
    bench.act(target, new_id())
    bench.check(expected)
