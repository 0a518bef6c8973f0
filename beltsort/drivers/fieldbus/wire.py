"""Requests and replies of the protocol between client and controller, independent of the fieldbus.

`docs/fieldbus.md` specifies the protocol and its numbers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from hashlib import blake2b
from typing import Self

from beltsort.cell.commands import Outcome
from beltsort.cell.protocols import NOWHERE
from beltsort.errors import CellError

MEMORY = 1000
"""Number of commands that a controller must remember."""

MAX_BINS = 32
"""Largest number of bins in a reply."""

READY, EMERGENCY_STOP = 1, 2
"""Flags of a reply."""

UNNUMBERED = 0
"""Sequence number of a request that has not been sent yet."""

SEQUENCES = 1 << 16
"""Sequence numbers are counted modulo this."""


class Verb(IntEnum):
    """The operation that a request asks for."""

    LOOK = 0
    """Return the state."""
    ADVANCE = 1
    """Bring object `target` to the belt end."""
    SORT = 2
    """Put the object at the belt end into bin `target`."""
    RECALL = 3
    """Return the outcome of the command `key`."""
    STOP = 4
    """End every motion."""
    HOME = 5
    """Set object `target` as the one at the belt end, as checked by an operator, and clear faults."""


COMMANDS = (Verb.ADVANCE, Verb.SORT)
"""Verbs that move something, and are executed once per key."""


class Phase(IntEnum):
    """The state of a command."""

    FORGOTTEN = 0
    """The controller does not remember it."""
    RUNNING = 1
    """It is running."""
    DONE = 2
    """It was executed."""
    NOT_DONE = 3
    """Nothing moved; the same id may be used again."""
    BROKEN_OFF = 4
    """It started and did not end as it should; the same id is never executed again."""


OUTCOMES = {
    Phase.RUNNING: Outcome.RUNNING,
    Phase.DONE: Outcome.DONE,
    Phase.NOT_DONE: Outcome.NOT_DONE,
    Phase.BROKEN_OFF: Outcome.BROKEN_OFF,
}
"""Outcomes of the commands that a controller remembers."""


class Reason(IntEnum):
    """Reason why a command was not done or was broken off, or why the controller is not ready."""

    NONE = 0
    EMERGENCY_STOP = 1
    NOT_HOMED = 2
    BUSY = 3
    BACKWARDS = 4
    OTHER_COMMAND = 5
    NO_SUCH_BIN = 6
    BIN_FULL = 7
    ALREADY_SORTED = 8
    BETWEEN_OBJECTS = 9
    STOPPED = 10
    STUCK = 11
    OVERSHOT = 12
    NO_SUCH_VERB = 13


NEED_HOME = frozenset({Reason.NOT_HOMED, Reason.STUCK, Reason.OVERSHOT})
"""Faults that only `HOME` clears, after an operator has checked the belt."""

HOMING = "check which object is at the belt end, and home the belt (beltsort home)"

EXPLANATIONS: dict[int, str] = {
    Reason.NONE: "it gives no reason",
    Reason.EMERGENCY_STOP: "the emergency stop is pressed; release it at the machine",
    Reason.NOT_HOMED: f"the controller does not know which object is at the belt end; {HOMING}",
    Reason.BUSY: "another command is still running; wait for it, or stop it",
    Reason.BACKWARDS: "the belt moves forward only",
    Reason.OTHER_COMMAND: "its id belongs to another command or target; give every command its own id",
    Reason.NO_SUCH_BIN: "the controller has no such bin",
    Reason.BIN_FULL: "the bin is full; empty it",
    Reason.ALREADY_SORTED: "the object at the belt end was sorted already; advance first",
    Reason.BETWEEN_OBJECTS: "the belt stands between two objects; advance first",
    Reason.STOPPED: "it was stopped during execution; check the cell",
    Reason.STUCK: f"the belt did not move; free it, {HOMING}",
    Reason.OVERSHOT: f"the belt went too far; {HOMING}",
    Reason.NO_SUCH_VERB: "the controller does not know this verb; compare versions of the protocol",
}


@dataclass(frozen=True)
class Request:
    """A request of the client, written atomically.

    Attributes
    ----------
    sequence
        Sequence number. A request is executed only if its number is ahead of the last one's (`is_ahead`).
    verb
        A `Verb`.
    target
        Object number or bin.
    key
        `key_of` the command id; 0 for requests that do not refer to a command.
    """

    sequence: int
    verb: int
    target: int = 0
    key: int = 0

    def numbered(self, sequence: int) -> Self:
        """Return the same request with a sequence number."""
        return replace(self, sequence=sequence)


@dataclass(frozen=True)
class Reply:
    """A reply of the controller, written atomically.

    Attributes
    ----------
    sequence, verb, key
        Those of the request.
    phase, reason
        State of the command `key`, and the reason: a `Reason`, or a device-specific number from 100 on.
    age
        Milliseconds since the command ended; 0 while it is running.
    boot
        Boot id, above 0; a new random number whenever the controller starts.
    position
        Number of the object at the belt end, or `NOWHERE`.
    remembered, forgotten
        Number of commands in memory, and of those removed from memory since the controller started.
    ready
        Whether the controller accepts commands.
    emergency_stop
        Whether the emergency stop is pressed.
    fault
        Reason why the controller is not ready; 0 if there is none.
    bins
        Number of objects in each bin.
    """

    sequence: int
    verb: int
    key: int
    phase: Phase
    reason: int
    age: int
    boot: int
    position: int
    remembered: int
    forgotten: int
    ready: bool
    emergency_stop: bool
    fault: int
    bins: tuple[int, ...]


class GarbageError(CellError):
    """The controller's reply contains an invalid value.

    Parameters
    ----------
    field
        Name of the invalid field.
    value
        Its value.
    expected
        The expected values.
    sequence
        Sequence of the reply.
    """

    def __init__(self, field: str, value: object, expected: str, sequence: int) -> None:
        self.sequence = sequence
        super().__init__(
            f"the controller's reply is garbage: {field} is {value}, expected {expected}; check that its "
            "program runs, and compare it with docs/fieldbus.md"
        )


def checked(
    *,
    sequence: int,
    verb: int,
    key: int,
    phase: int,
    reason: int,
    age: int,
    boot: int,
    position: int,
    remembered: int,
    forgotten: int,
    flags: int,
    fault: int,
    bins: Sequence[int],
) -> Reply:
    """Return a reply after validating its values.

    Parameters
    ----------
    flags
        Bitwise or of `READY` and `EMERGENCY_STOP`.

    Raises
    ------
    GarbageError
        If a value is out of its range.
    """
    limits = {
        "phase": (phase, 0, len(Phase) - 1),
        "boot id": (boot, 1, 2**63 - 1),
        "position": (position, NOWHERE, 2**31 - 1),
        "flags": (flags, 0, READY | EMERGENCY_STOP),
        "number of bins": (len(bins), 0, MAX_BINS),
        "age": (age, 0, 2**63 - 1),
        "remembered": (remembered, 0, 2**63 - 1),
        "forgotten": (forgotten, 0, 2**63 - 1),
    }
    check_limits(limits, sequence)
    return Reply(
        sequence,
        verb,
        key,
        Phase(phase),
        reason,
        age,
        boot,
        position,
        remembered,
        forgotten,
        bool(flags & READY),
        bool(flags & EMERGENCY_STOP),
        fault,
        tuple(bins),
    )


def check_limits(limits: Mapping[str, tuple[int, int, int]], sequence: int) -> None:
    """Check values of a reply.

    Parameters
    ----------
    limits
        For each field its value, the least and the most that it may be.
    sequence
        Sequence of the reply.

    Raises
    ------
    GarbageError
        For the first that is out of its range.
    """
    for field, (value, least, most) in limits.items():
        if not least <= value <= most:
            raise GarbageError(field, value, f"{least} to {most}", sequence)


def key_of(command_id: str) -> int:
    """Return the key of a command id, a hash from 1 to 2^63 - 1.

    The probability that any two of a million ids have the same key is 5e-8.

    Examples
    --------
    >>> 0 < key_of("sort-12") < 2**63
    True
    >>> key_of("sort-12") == key_of("sort-13")
    False
    """
    digest = blake2b(command_id.encode(), digest_size=8).digest()
    return max(1, int.from_bytes(digest) >> 1)


def boot_id_of(boot: int) -> str:
    """Return the boot id of a device whose controller has a number for it.

    Examples
    --------
    >>> boot_id_of(0xC0FFEE)
    '00c0ffee'
    """
    return f"{boot:08x}"


def following(sequence: int) -> int:
    """Return the next sequence number."""
    return (sequence + 1) % SEQUENCES


def is_ahead(sequence: int, of: int) -> bool:
    """Return whether a sequence number is ahead of another by less than half the range.

    Examples
    --------
    >>> is_ahead(3, of=65535), is_ahead(3, of=3), is_ahead(65535, of=3)
    (True, False, False)
    """
    return 0 < (sequence - of) % SEQUENCES < SEQUENCES // 2


def explained(fault: int) -> str:
    """Return the explanation of a reason or fault, with its remedy."""
    device_specific = (
        f"the controller reports device-specific fault {fault}; look it up in the machine's manual"
    )
    return EXPLANATIONS.get(fault, device_specific)
