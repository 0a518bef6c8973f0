"""The protocol of a belt that never stops: its encoder, and diversions of objects into bins.

A diversion is queued at the controller, which carries it out when the object comes by the bin's diverter;
`docs/fieldbus.md`, "A belt that never stops", has the controller's rules. The rules of
`beltsort.cell.protocols` hold here too, with these differences:

* `divert` returns when the controller has accepted or refused the diversion, long before the object comes by.
* The outcome is final once it is neither `QUEUED` nor `UNKNOWN`. An object without a final outcome is in no
  bin because of its diversion, or in the bin that the diversion names.
* Objects are identified by their coordinate: the belt's travel when their centre passes the reference mark,
  which does not change while they are on the belt. A coordinate is valid for one `boot_id` only, since the
  travel begins at 0 with every start of the controller.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol, runtime_checkable

from beltsort.cell.commands import TIMEOUT
from beltsort.cell.protocols import Arm, DepthCamera, Device
from beltsort.geometry import BeltLayout


class Diversion(Enum):
    """The state of a diversion."""

    QUEUED = "queued"
    """It is carried out when the object comes by the diverter, also if the connection is lost."""
    DONE = "done"
    """The object is in the bin."""
    NOT_DONE = "not done"
    """It was refused, or the diverter did not move: the object is in no bin because of it."""
    TOO_LATE = "too late"
    """It came after the last moment: the object goes to the overflow."""
    UNKNOWN = "unknown"
    """The controller does not remember it, or cannot be asked."""

    @property
    def final(self) -> bool:
        """Whether it does not change any more."""
        return self not in (Diversion.QUEUED, Diversion.UNKNOWN)


@dataclass(frozen=True)
class DiversionStatus:
    """What a controller says of a diversion.

    Attributes
    ----------
    state
        Its state.
    boot_id
        That of the controller that answered.
    reason
        Why it was not done, with the remedy; empty if there is none.
    retry
        Whether the controller has refused it without remembering it, so that it may be sent again under the
        same id.
    """

    state: Diversion
    boot_id: str
    reason: str = ""
    retry: bool = False


@dataclass(frozen=True)
class BeltReading:
    """A reading of the belt's encoder.

    Attributes
    ----------
    stamp
        Its time, seconds on the cell's clock.
    travel
        How far the belt has moved since the start of its controller, metres.
    boot_id
        Changes with every start of the controller.
    moving
        Whether the belt moves.
    emergency_stop
        Whether the emergency stop is pressed.
    error
        Most that `stamp` may be wrong by, seconds.
    """

    stamp: float
    travel: float
    boot_id: str
    moving: bool = True
    emergency_stop: bool = False
    error: float = 0.0


class DivertingBelt(Device, Protocol):
    """A belt that never stops, with a diverter for each bin."""

    def reading(self, *, timeout: float = TIMEOUT) -> BeltReading:
        """Return how far the belt has moved, now. Raises `CommandError` if it cannot be asked."""

    def divert(
        self,
        command_id: str,
        *,
        number: int,
        coordinate: float,
        label: int,
        boot_id: str,
        timeout: float = TIMEOUT,
    ) -> DiversionStatus:
        """Queue a diversion.

        The same diversion may be sent again under its id: it is queued at most once, and its state is
        returned.

        Parameters
        ----------
        command_id
            Its id; an id belongs to one diversion for ever.
        number
            Number of the object, for the controller's messages. No other object has it in the same `boot_id`.
        coordinate
            Coordinate of the object's centre, metres.
        label
            Index of the bin. A driver of a cell file gets the controller's number of the bin.
        boot_id
            `BeltReading.boot_id` of the readings from which the coordinate was computed.
        timeout
            Seconds.

        Raises
        ------
        CommandError
            If the controller cannot be asked; with `Outcome.UNKNOWN` if the diversion may have arrived.
        """

    def diversion(self, command_id: str, *, boot_id: str, timeout: float = TIMEOUT) -> DiversionStatus:
        """Return the state of a diversion.

        It is `NOT_DONE` (with `retry`) for one that never arrived and never will, and `UNKNOWN` if the
        controller may have forgotten it, for example after a restart.

        Parameters
        ----------
        command_id
            Its id.
        boot_id
            The boot id with which it was sent.
        timeout
            Seconds.

        Raises
        ------
        CommandError
            If the controller cannot be asked.
        """


@runtime_checkable
class KnowsClassesAt(Protocol):
    """A simulated world in which the class of every object on the belt is known."""

    def true_class_at(self, coordinate: float) -> int | None:
        """Return the class index of the object at a coordinate; None for an empty cup."""


class DivertingCell(Protocol):
    """Arm, camera and a belt that never stops, with their configuration."""

    @property
    def arm(self) -> Arm:
        """The arm that carries the camera."""

    @property
    def camera(self) -> DepthCamera:
        """The depth camera."""

    @property
    def belt(self) -> DivertingBelt:
        """The belt with its diverters."""

    @property
    def classes(self) -> Sequence[str]:
        """Names of the object classes; one bin each, unless the cell names its bins (`NamesBins`)."""

    @property
    def viewpoints(self) -> Sequence[str]:
        """Names of the viewpoints."""

    @property
    def layout(self) -> BeltLayout:
        """The belt's geometry: sizes of cups, their regular distance, and the number of places seen."""

    def wait(self, seconds: float) -> None:
        """Let time pass on the cell's clock."""
