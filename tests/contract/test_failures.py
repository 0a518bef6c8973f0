"""What controllers on a fieldbus do when the machine, the controller or the network fails."""

import re
from concurrent.futures import Future

import pytest

from beltsort.cell import CommandError, EmergencyStopError, Outcome
from beltsort.drivers.fieldbus import FieldbusDevice
from tests.account import Account
from tests.contract.bench import begun, error_of, named, new_id
from tests.contract.peer import PATIENCE
from tests.contract.peers import LONG_WAY, ServerPeer

pytestmark = pytest.mark.process


@pytest.fixture(autouse=True)
def noted(request: pytest.FixtureRequest, account: Account) -> None:
    """Each of these tests injects a fault."""
    (peer,) = request.node.callspec.params.values()
    account.injected(named(peer))


def moving(server: ServerPeer, device: FieldbusDevice, command_id: str) -> Future[object]:
    """Let the belt go a long way, and return when it moves."""
    return begun(lambda: device.advance_to(LONG_WAY, command_id), lambda: server.busy("belt"))


def test_a_restarted_controller_waits_until_somebody_has_looked(server: ServerPeer) -> None:
    device = server.device()
    device.sort(0, new_id())
    server.kill()
    server.restart()
    health = device.health()
    assert health.boot_id == server.boot_id
    assert not health.ready
    assert "beltsort home" in health.fault
    with pytest.raises(CommandError, match=r"\bbeltsort home\b") as error:
        device.sort(0, new_id())
    assert error.value.outcome is Outcome.NOT_DONE
    device.home(7)
    device.advance_to(8, new_id())


def test_a_stuck_belt_has_not_moved_and_may_try_again(server: ServerPeer) -> None:
    device, command_id = server.device(), new_id()
    server.push("stick")
    with pytest.raises(CommandError, match=r"advanc\w+ .*\b2\b.*\bmove\b.*\bbeltsort home\b") as error:
        device.advance_to(2, command_id)
    assert error.value.outcome is device.outcome_of(command_id) is Outcome.NOT_DONE
    assert re.search(r"\bmove\b.*\bbeltsort home\b", device.health().fault)
    device.home(0)
    device.advance_to(2, command_id)
    assert device.outcome_of(command_id) is Outcome.DONE


def test_a_belt_that_goes_too_far_says_where_it_is(server: ServerPeer) -> None:
    device, command_id = server.device(), new_id()
    server.push("overshoot")
    with pytest.raises(CommandError, match=r"\btoo far\b.*\bbeltsort home\b.*\bobject 3\b") as error:
        device.advance_to(2, command_id)
    assert error.value.outcome is device.outcome_of(command_id) is Outcome.BROKEN_OFF
    with pytest.raises(CommandError, match=r"\btoo far\b.*\bbeltsort home\b") as error:
        device.sort(0, new_id())
    assert error.value.outcome is Outcome.NOT_DONE
    device.home(3)
    device.sort(0, new_id())


def test_the_emergency_stop_ends_a_command_and_refuses_the_next(server: ServerPeer) -> None:
    device, command_id = server.device(), new_id()
    advance = moving(server, device, command_id)
    server.push("press")
    failure = error_of(advance)
    assert isinstance(failure, EmergencyStopError)
    assert failure.outcome is device.outcome_of(command_id) is Outcome.BROKEN_OFF
    health = device.health()
    assert health.emergency_stop
    assert not health.ready
    with pytest.raises(EmergencyStopError) as error:
        device.sort(0, new_id())
    assert error.value.outcome is Outcome.NOT_DONE
    server.push("release")
    assert device.health().ready


def test_stop_from_another_thread_ends_a_command(server: ServerPeer) -> None:
    device, command_id = server.device(), new_id()
    advance = moving(server, device, command_id)
    device.stop()
    failure = error_of(advance)
    assert "stopped" in str(failure)
    assert failure.outcome is device.outcome_of(command_id) is Outcome.BROKEN_OFF
    with pytest.raises(CommandError, match=r"\bbetween\b"):
        device.sort(0, new_id())
    device.home(5)
    device.sort(0, new_id())


def test_a_deadline_leaves_the_command_acting(server: ServerPeer) -> None:
    device, command_id = server.device(), new_id()
    server.push("slow")
    # On a busy machine the last look before the deadline may be one that is broken off.
    with pytest.raises(CommandError, match=r"\b1 s\b|cannot be asked") as error:
        device.advance_to(2, command_id, timeout=1.0)
    assert error.value.outcome in (Outcome.RUNNING, Outcome.UNKNOWN)
    with pytest.raises(CommandError, match=r"\bcommand\b.*\bstop it\b") as error:
        device.advance_to(2, new_id())
    assert error.value.outcome is Outcome.NOT_DONE
    device.advance_to(2, command_id)
    assert device.outcome_of(command_id) is Outcome.DONE


def test_nobody_there(server: ServerPeer) -> None:
    device = server.unreachable()
    with pytest.raises(CommandError, match=r"(Error|Timeout|Lost)\b.*\baddress\b.*\bcertificates\b") as error:
        device.sort(0, new_id(), timeout=PATIENCE)
    assert error.value.outcome is Outcome.NOT_DONE
    for ask in (device.health, device.stop, lambda: device.outcome_of("any")):
        with pytest.raises(CommandError, match=r"(Error|Timeout|Lost)\b.*\baddress\b.*\bcertificates\b"):
            ask()


def test_a_stranger_is_turned_away(secure_server: ServerPeer) -> None:
    for device in (secure_server.untrusted(), secure_server.distrustful()):
        with pytest.raises(CommandError, match="certificates") as error:
            device.sort(0, new_id())
        assert error.value.outcome is Outcome.NOT_DONE
    assert secure_server.device().health().boot_id == secure_server.boot_id


def test_another_program_learns_what_became_of_a_command(server: ServerPeer) -> None:
    device, command_id = server.device(), new_id()
    device.advance_to(1, command_id)
    device.close()
    restarted = server.unhomed()
    assert restarted.outcome_of(command_id) is Outcome.DONE
    assert restarted.outcome_of(new_id(), restarted.health().boot_id) is Outcome.NOT_DONE
    restarted.advance_to(1, command_id)
    restarted.sort(0, new_id())
