"""Requests and replies about diversions on a belt that never stops, independent of the fieldbus.

`docs/fieldbus.md`, "A belt that never stops", specifies the rules and the numbers.
"""

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from enum import IntEnum
from typing import Self

from beltsort.drivers.fieldbus.link import MissingPartError
from beltsort.drivers.fieldbus.wire import MAX_BINS, GarbageError, check_limits

VERSION = 1
"""Version of this part of the protocol, with which every reply of a controller begins that has it."""

MOVING, EMERGENCY_STOP_PRESSED = 1, 2
"""Flags of a reply: the belt moves; the emergency stop is pressed."""

QUEUE = 64
"""Number of queued diversions that a controller must be able to hold."""


class DiversionVerb(IntEnum):
    """The operation that a request asks for. The numbers are those of `Verb` where both have it."""

    LOOK = 0
    """Return the state."""
    RECALL = 3
    """Return the outcome of the diversion `key`."""
    STOP = 4
    """Stop the belt; what is queued stays queued."""
    DIVERT = 6
    """Put the object into the bin when it comes by the bin's diverter."""


class DiversionPhase(IntEnum):
    """The state of a diversion."""

    UNKNOWN = 0
    """The controller does not remember it."""
    QUEUED = 1
    """It is carried out when the object comes by the diverter."""
    DONE = 2
    """The object is in the bin."""
    NOT_DONE = 3
    """It was refused, or the diverter did not move; the object is in no bin because of it."""
    TOO_LATE = 4
    """It came after the last moment; the object goes to the overflow."""


class DiversionReason(IntEnum):
    """Reason why a diversion was not done. The numbers are those of `Reason` where both have it."""

    NONE = 0
    EMERGENCY_STOP = 1
    OTHER_COMMAND = 5
    NO_SUCH_BIN = 6
    BIN_FULL = 7
    NO_SUCH_VERB = 13
    QUEUE_FULL = 14
    ALREADY_DIVERTED = 15
    OTHER_BOOT = 16


DIVERSION_EXPLANATIONS: dict[DiversionReason, str] = {
    DiversionReason.NONE: "it gives no reason",
    DiversionReason.EMERGENCY_STOP: "the emergency stop is pressed; release it at the machine",
    DiversionReason.OTHER_COMMAND: "its key is 0 or belongs to another diversion; give every one its own",
    DiversionReason.NO_SUCH_BIN: "the controller has no such bin",
    DiversionReason.BIN_FULL: "the bin is full, or will be by what is queued; empty it",
    DiversionReason.NO_SUCH_VERB: "the controller does not know this verb; compare versions of the protocol",
    DiversionReason.QUEUE_FULL: "the queue is full; send it again when an object was diverted",
    DiversionReason.ALREADY_DIVERTED: "the object has a diversion under another key; ask for its outcome",
    DiversionReason.OTHER_BOOT: "the coordinate is from before a restart of the controller; measure it again",
}
"""Explanation of each reason, with its remedy."""


@dataclass(frozen=True)
class DiversionRequest:
    """A request of the client, written atomically.

    Attributes
    ----------
    sequence
        Sequence number, new by the rule of `is_ahead`.
    verb
        A `DiversionVerb`.
    key
        `key_of` the command id; 0 for requests that do not refer to a diversion.
    object
        Number of the object, for messages and for the account; the coordinate says where it is.
    coordinate
        Belt coordinate of the object's centre, micrometres.
    bin
        Bin number, from 0.
    boot
        Boot id of the controller with whose encoder the coordinate was measured.
    """

    sequence: int
    verb: int
    key: int = 0
    object: int = 0
    coordinate: int = 0
    bin: int = 0
    boot: int = 0

    def numbered(self, sequence: int) -> Self:
        """Return the same request with a sequence number."""
        return replace(self, sequence=sequence)


@dataclass(frozen=True)
class DiversionReply:
    """A reply of the controller, written atomically.

    Attributes
    ----------
    sequence, verb, key
        Those of the request.
    phase, reason
        State of the diversion `key`, and the reason.
    boot
        Boot id; a new random number whenever the controller starts.
    position
        Belt coordinate that is at the reference mark, micrometres since the start of the controller.
    stamp
        Time at which `position` was read from the encoder, microseconds on the controller's clock.
    moving
        Whether the belt moves.
    emergency_stop
        Whether the emergency stop is pressed.
    queued
        Number of diversions in the queue.
    forgotten
        Number of ended diversions removed from memory since the start.
    bins
        Number of objects in each bin.
    """

    sequence: int
    verb: int
    key: int
    phase: DiversionPhase
    reason: DiversionReason
    boot: int
    position: int
    stamp: int
    moving: bool
    emergency_stop: bool
    queued: int
    forgotten: int
    bins: tuple[int, ...]


def checked_diversion(
    *,
    version: int,
    sequence: int,
    verb: int,
    key: int,
    phase: int,
    reason: int,
    boot: int,
    position: int,
    stamp: int,
    flags: int,
    queued: int,
    forgotten: int,
    bins: Sequence[int],
) -> DiversionReply:
    """Return a reply after validating its values.

    Parameters
    ----------
    version
        Version of the protocol.
    flags
        Bitwise or of `MOVING` and `EMERGENCY_STOP_PRESSED`.

    Raises
    ------
    MissingPartError
        If the version is 0: the controller has no diversions.
    GarbageError
        If a value is out of its range.
    """
    if version == 0:
        raise MissingPartError("the version of its diversions is 0")
    most = 2**63 - 1
    limits = {
        "version": (version, VERSION, VERSION),
        "phase": (phase, 0, len(DiversionPhase) - 1),
        "boot id": (boot, 1, most),
        "position": (position, -most, most),
        "stamp": (stamp, 0, most),
        "flags": (flags, 0, MOVING | EMERGENCY_STOP_PRESSED),
        "number of bins": (len(bins), 0, MAX_BINS),
        "queued": (queued, 0, most),
        "forgotten": (forgotten, 0, most),
    }
    check_limits(limits, sequence)
    if reason not in set(DiversionReason):
        raise GarbageError("reason", reason, f"one of {[int(known) for known in DiversionReason]}", sequence)
    return DiversionReply(
        sequence,
        verb,
        key,
        DiversionPhase(phase),
        DiversionReason(reason),
        boot,
        position,
        stamp,
        bool(flags & MOVING),
        bool(flags & EMERGENCY_STOP_PRESSED),
        queued,
        forgotten,
        tuple(bins),
    )


REPLY_NUMBERS = 13
"""Number of `reply_numbers`."""


def reply_numbers(reply: DiversionReply) -> list[int]:
    """Return the numbers of a reply, for layouts in which all have 64 bits.

    They are version, sequence, verb, key, phase, reason, boot, position, stamp, moving, emergency stop,
    queued and forgotten; the bins are apart, since their number varies.
    """
    *numbers, _bins = astuple(reply)
    return [VERSION, *(int(number) for number in numbers)]


def reply_of(numbers: Sequence[int], bins: Sequence[int]) -> DiversionReply:
    """Return the reply with these `reply_numbers` and bins; errors as of `checked_diversion`."""
    version, sequence, verb, key, phase, reason, boot, position, stamp = numbers[:9]
    moving, emergency_stop, queued, forgotten = numbers[9:]
    return checked_diversion(
        version=version,
        sequence=sequence,
        verb=verb,
        key=key,
        phase=phase,
        reason=reason,
        boot=boot,
        position=position,
        stamp=stamp,
        flags=MOVING * bool(moving) | EMERGENCY_STOP_PRESSED * bool(emergency_stop),
        queued=queued,
        forgotten=forgotten,
        bins=bins,
    )
