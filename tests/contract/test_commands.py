"""What belt and sorter of one controller know of each other."""

import pytest

from beltsort.cell import CommandError, Outcome
from tests.contract.bench import new_id
from tests.contract.peer import BeltAndSorter

pytestmark = pytest.mark.process


def test_a_command_is_done_when_it_returns(device: BeltAndSorter) -> None:
    assert device.health().ready
    sort, advance = new_id(), new_id()
    device.sort(1, sort)
    stop = device.advance_to(1, advance)
    assert device.outcome_of(sort) is device.outcome_of(advance) is Outcome.DONE
    device.sort(0, new_id())
    assert device.advance_to(3, new_id()) > stop


def test_a_repeated_command_acts_once(device: BeltAndSorter) -> None:
    sort, advance = new_id(), new_id()
    device.sort(1, sort)
    device.sort(1, sort)
    device.advance_to(2, advance)
    device.advance_to(2, advance)
    device.sort(1, new_id())
    device.sort(1, sort)


def test_an_old_command_repeated_moves_nothing(device: BeltAndSorter) -> None:
    first, second = new_id(), new_id()
    device.advance_to(1, first)
    device.advance_to(2, second)
    device.advance_to(1, first)
    device.sort(0, new_id())
    with pytest.raises(CommandError, match=r"\bsorted\b"):
        device.sort(0, new_id())


def test_an_id_belongs_to_one_command(device: BeltAndSorter) -> None:
    advance = new_id()
    device.advance_to(1, advance)
    for other in (lambda: device.advance_to(2, advance), lambda: device.sort(0, advance)):
        with pytest.raises(CommandError, match=r"\bid\b.*\bcommand\b") as error:
            other()
        assert error.value.outcome is Outcome.NOT_DONE
    assert device.outcome_of(advance) is Outcome.DONE


def test_refusals_say_that_nothing_was_done_and_leave_the_id_free(device: BeltAndSorter) -> None:
    device.advance_to(2, new_id())
    command_id = new_id()
    with pytest.raises(CommandError, match=r"\bforward\b") as error:
        device.advance_to(1, command_id)
    assert error.value.outcome is device.outcome_of(command_id) is Outcome.NOT_DONE
    with pytest.raises(CommandError, match="bin") as error:
        device.sort(17, command_id)
    assert error.value.outcome is Outcome.NOT_DONE
    device.sort(1, command_id)
    assert device.outcome_of(command_id) is Outcome.DONE


def test_what_was_never_sent_is_not_done(device: BeltAndSorter) -> None:
    device.advance_to(1, new_id())
    assert device.outcome_of(new_id(), device.health().boot_id) is Outcome.NOT_DONE
