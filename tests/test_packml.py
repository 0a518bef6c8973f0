"""The states of a machine, against ISA-TR88.00.02."""

import pytest

from beltsort.errors import CellError
from beltsort.sorting.packml import TRANSITIONS, Command, State, after

ACTING = {state for state in State if state.endswith("ing")} | {State.EXECUTE}


def follow(state: State, *commands: Command) -> State:
    for command in commands:
        state = after(state, command)
    return state


def test_there_are_seventeen_states_and_each_can_be_reached_and_left() -> None:
    assert len(State) == 17
    assert set(TRANSITIONS.values()) == set(State)
    assert {state for state, _ in TRANSITIONS} == set(State)


def test_exactly_the_acting_states_complete_by_themselves() -> None:
    assert {state for state, command in TRANSITIONS if command is Command.STATE_COMPLETE} == ACTING


def test_no_command_leads_from_a_state_to_itself() -> None:
    assert all(state is not following for (state, _), following in TRANSITIONS.items())


def test_a_run() -> None:
    done = Command.STATE_COMPLETE
    assert follow(State.STOPPED, Command.RESET, done, Command.START, done) is State.EXECUTE
    assert follow(State.EXECUTE, done, done, Command.RESET, done) is State.IDLE
    assert follow(State.EXECUTE, Command.HOLD, done, Command.UNHOLD, done) is State.EXECUTE
    assert follow(State.EXECUTE, Command.SUSPEND, done, Command.UNSUSPEND, done) is State.EXECUTE


@pytest.mark.parametrize("state", State)
def test_abort_is_always_possible_and_stop_unless_the_machine_ends_already(state: State) -> None:
    aborted = {State.ABORTING, State.ABORTED}
    assert ((state, Command.ABORT) in TRANSITIONS) == (state not in aborted)
    ending = aborted | {State.STOPPING, State.STOPPED, State.CLEARING}
    assert ((state, Command.STOP) in TRANSITIONS) == (state not in ending)


def test_an_abort_must_be_cleared_before_anything_starts() -> None:
    done = Command.STATE_COMPLETE
    with pytest.raises(CellError, match=r"\bStart\b.*\bAborted\b.*\bClear\b"):
        follow(State.EXECUTE, Command.ABORT, done, Command.START)
    assert follow(State.ABORTED, Command.CLEAR, done) is State.STOPPED
