"""The states of a machine and what leads from one to another, as packaging lines know them.

References
----------
ISA-TR88.00.02-2015, "Machine and unit states (PackML)"; OPC 30050, "PackML". Without the optional ways to
Holding from Starting, Suspended and others.
"""

from enum import StrEnum

from beltsort.errors import CellError
from beltsort.util.naming import nearest_of


class State(StrEnum):
    """What the machine does, or waits for."""

    STOPPED = "Stopped"
    RESETTING = "Resetting"
    IDLE = "Idle"
    STARTING = "Starting"
    EXECUTE = "Execute"
    COMPLETING = "Completing"
    COMPLETE = "Complete"
    HOLDING = "Holding"
    HELD = "Held"
    UNHOLDING = "Unholding"
    SUSPENDING = "Suspending"
    SUSPENDED = "Suspended"
    UNSUSPENDING = "Unsuspending"
    STOPPING = "Stopping"
    ABORTING = "Aborting"
    ABORTED = "Aborted"
    CLEARING = "Clearing"


class Command(StrEnum):
    """What leads from one state to another."""

    RESET = "Reset"
    START = "Start"
    HOLD = "Hold"
    UNHOLD = "Unhold"
    SUSPEND = "Suspend"
    UNSUSPEND = "Unsuspend"
    STOP = "Stop"
    ABORT = "Abort"
    CLEAR = "Clear"
    STATE_COMPLETE = "State complete"
    """The machine's own: what an acting state does is done."""


_ENDING = {State.STOPPING, State.STOPPED, State.ABORTING, State.ABORTED, State.CLEARING}

TRANSITIONS: dict[tuple[State, Command], State] = {
    (State.STOPPED, Command.RESET): State.RESETTING,
    (State.COMPLETE, Command.RESET): State.RESETTING,
    (State.IDLE, Command.START): State.STARTING,
    (State.EXECUTE, Command.HOLD): State.HOLDING,
    (State.HELD, Command.UNHOLD): State.UNHOLDING,
    (State.EXECUTE, Command.SUSPEND): State.SUSPENDING,
    (State.SUSPENDED, Command.UNSUSPEND): State.UNSUSPENDING,
    (State.ABORTED, Command.CLEAR): State.CLEARING,
    (State.RESETTING, Command.STATE_COMPLETE): State.IDLE,
    (State.STARTING, Command.STATE_COMPLETE): State.EXECUTE,
    (State.EXECUTE, Command.STATE_COMPLETE): State.COMPLETING,
    (State.COMPLETING, Command.STATE_COMPLETE): State.COMPLETE,
    (State.HOLDING, Command.STATE_COMPLETE): State.HELD,
    (State.UNHOLDING, Command.STATE_COMPLETE): State.EXECUTE,
    (State.SUSPENDING, Command.STATE_COMPLETE): State.SUSPENDED,
    (State.UNSUSPENDING, Command.STATE_COMPLETE): State.EXECUTE,
    (State.STOPPING, Command.STATE_COMPLETE): State.STOPPED,
    (State.ABORTING, Command.STATE_COMPLETE): State.ABORTED,
    (State.CLEARING, Command.STATE_COMPLETE): State.STOPPED,
    **{(state, Command.STOP): State.STOPPING for state in State if state not in _ENDING},
    **{
        (state, Command.ABORT): State.ABORTING
        for state in State
        if state not in (State.ABORTING, State.ABORTED)
    },
}
"""The next state by state and command; what is not here is not allowed."""


def after(state: State, command: Command) -> State:
    """Return the state that a command leads to.

    Raises
    ------
    CellError
        If the command is not allowed in this state.

    Examples
    --------
    >>> after(State.EXECUTE, Command.HOLD).value
    'Holding'
    """
    if (state, command) not in TRANSITIONS:
        allowed = [known.value for held, known in TRANSITIONS if held is state]
        raise CellError(
            f"the command is {command.value} in state {state.value}, which does not allow it; "
            f"{nearest_of(command.value, allowed)}"
        )
    return TRANSITIONS[state, command]
