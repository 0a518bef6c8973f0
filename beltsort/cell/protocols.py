"""The protocols of a robot cell: an arm that carries a depth camera, a belt, and a sorter.

The rules for every device, by which no command is lost or executed twice:

* A call blocks until the command is done, and no longer than its `timeout` (seconds). After a timeout or a
  failure it raises a `CommandError` with the outcome of the command.
* A command has an id, unique for the device, under which it is executed at most once. `outcome_of` returns
  its outcome, also after the connection or this program was restarted. A command that was interrupted during
  execution is never executed again under its id; to repeat it, use a new one.
* Targets are absolute: "object n at the belt end", never "one step further".
* A scan begins after arm and belt have stopped. Both times are on the cell's clock: for real devices
  `time.monotonic`, so that setting the time of day does not change their order; simulated devices have a
  clock of their own.
* Poses are in the robot's world frame; a cell that is composed of devices transforms them to the belt frame.
* After a restart of its controller a device has another `boot_id`. The outcome of a command that it no longer
  remembers is then unknown, rather than not done.

The emergency stop is a function of the hardware. Software only reports it (`Health.emergency_stop`,
`EmergencyStopError`) and aborts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from beltsort.cell.commands import TIMEOUT, Outcome
from beltsort.geometry import BeltLayout, Points, Pose

NOWHERE = -1
"""The position of a belt that moves, stands between two objects, or has not been homed."""


@dataclass(frozen=True)
class Scan:
    """A scan of the depth camera.

    Attributes
    ----------
    points
        Points in the *camera* frame, metres: (height, width, 3) for an organised depth image, NaN where a
        pixel has no return, or (n, 3).
    world_from_camera
        The camera's pose, shape (4, 4). From a driver it is in the robot's world frame, or NaN if not known;
        from a cell that is composed of drivers it is in the belt frame.
    stamp
        Time at which the exposure began, seconds on the cell's clock.
    frame
        Name of the camera frame.
    assumed
        Whether the camera's pose is not known, and `world_from_camera` is that of the viewpoint instead.
    """

    points: Points
    world_from_camera: Pose
    stamp: float
    frame: str = "camera"
    assumed: bool = False

    def __repr__(self) -> str:
        """Return the number of points and where the camera stood."""
        shape, camera = " x ".join(map(str, self.points.shape[:-1])), self.world_from_camera[:3, 3]
        position = ", ".join(f"{value:.3f}" for value in camera)
        where = f"assumed at ({position})" if self.assumed else f"at ({position})"
        return f"Scan({shape} points, camera {self.frame!r} {where} m, stamp {self.stamp:.3f} s)"


@dataclass(frozen=True)
class Health:
    """The state of a device.

    Attributes
    ----------
    ready
        Whether it accepts commands.
    boot_id
        Changes with every restart of its controller.
    fault
        The reason why it is not ready; empty if it is.
    emergency_stop
        Whether the emergency stop is pressed.
    needs_home
        Whether it accepts no commands until an operator has set the object at the belt end (`Homing.home`).
    """

    ready: bool
    boot_id: str
    fault: str = ""
    emergency_stop: bool = False
    needs_home: bool = False


class Device(Protocol):
    """A device."""

    def health(self) -> Health:
        """Return its state. Raises `CommandError` if it cannot be reached."""

    def stop(self) -> None:
        """Stop every motion now, also of commands in execution. May be called from any thread."""


class Actuator(Device, Protocol):
    """A device that executes commands."""

    def outcome_of(self, command_id: str, boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command.

        It is `NOT_DONE` for a command that never arrived, and `UNKNOWN` if the device may have forgotten it,
        for example after a restart.

        Parameters
        ----------
        command_id
            The id of the command.
        boot_id
            `Health.boot_id` from before the command was sent; empty if not known.
        """


class Arm(Actuator, Protocol):
    """Carries the camera."""

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Move the camera to `viewpoint`; return the time of its stop, seconds on the cell's clock."""


class DepthCamera(Device, Protocol):
    """Takes scans."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan whose exposure began at or after `not_before` (seconds on the cell's clock)."""


class Belt(Actuator, Protocol):
    """Carries the objects."""

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Advance until object `index` is at the belt end; return the time of the stop.

        The time is in seconds on the cell's clock.
        """


class Sorter(Actuator, Protocol):
    """Puts the object at the belt end into a bin."""

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into a bin.

        Parameters
        ----------
        label
            Index of the bin: that of the class, unless the cell names its bins (`NamesBins`); or the cell's
            `reject_bin`. A driver of a cell file gets the sorter's number of the bin.
        command_id, timeout
            As in the module's docstring.
        """


@runtime_checkable
class Homing(Protocol):
    """A belt whose position an operator must set if it is not known. The program never homes it by itself."""

    def home(self, index: int, *, timeout: float = TIMEOUT) -> None:
        """Set the number of the object at the belt end."""


@runtime_checkable
class TellsPosition(Protocol):
    """A belt that reports its position."""

    def position(self) -> int | None:
        """Return the number of the object at the belt end.

        `NOWHERE` while the belt moves, stands between two objects, or has not been homed; None if it is not
        set up to report its position. Raises `CommandError` if it cannot be reached.
        """


@runtime_checkable
class Addressed(Protocol):
    """A device that only one run may use at a time."""

    @property
    def address(self) -> str:
        """Name of the device on this machine and its networks, such as `opc.tcp://192.168.0.5:4840`."""


@runtime_checkable
class TellsFlangePose(Protocol):
    """An arm that reports the pose of its flange."""

    def flange_pose(self, *, timeout: float = TIMEOUT) -> Pose | None:
        """Return the flange's pose in the robot's world frame, shape (4, 4), or None if not set up for it.

        Raises `CommandError` if the arm cannot be asked.
        """


@runtime_checkable
class KnowsPoses(Protocol):
    """A cell that knows the camera's pose at its viewpoints."""

    @property
    def poses(self) -> Sequence[Pose | None]:
        """The camera's pose at each viewpoint in the belt frame, shape (4, 4), or None."""


@runtime_checkable
class NamesBins(Protocol):
    """A cell whose bins need not be one for each class."""

    @property
    def bin_names(self) -> Sequence[str]:
        """Names of the bins in the order of the model's, without the reject bin; if empty, the classes."""


@runtime_checkable
class NumbersBins(Protocol):
    """A cell whose sorter has its own numbers for the bins."""

    @property
    def bin_numbers(self) -> Sequence[int]:
        """The sorter's number of each bin, the reject bin last; if empty, the numbers are the indices."""


@runtime_checkable
class KnowsClasses(Protocol):
    """A simulated world, in which the class of every object is known."""

    def true_class(self, index: int) -> int | None:
        """Return the class index of object `index`; None for an empty cup."""


@runtime_checkable
class FollowsBelt(Protocol):
    """A simulated world whose objects are moved by the cell's belt."""

    def follow(self, index: int, stopped: float) -> None:
        """Place object `index` at the belt end as of `stopped`, seconds on the cell's clock."""


@runtime_checkable
class Restorable(Protocol):
    """A device whose state is lost with the process, such as a simulated one."""

    def restore(self, index: int, *, first: int, looks: int, taken: bool, clock: float) -> None:
        """Set the state at which a run begins or is resumed.

        Parameters
        ----------
        index
            Number of the object at the belt end.
        first
            Number of the first object of the run.
        looks
            Number of scans since it arrived there.
        taken
            Whether it has been sorted.
        clock
            Time of the cell's clock, seconds.
        """


class Cell(Protocol):
    """Arm, camera, belt and sorter with their configuration. One device may have several of these roles."""

    @property
    def arm(self) -> Arm:
        """The arm that carries the camera."""

    @property
    def camera(self) -> DepthCamera:
        """The depth camera."""

    @property
    def belt(self) -> Belt:
        """The belt."""

    @property
    def sorter(self) -> Sorter:
        """The sorter."""

    @property
    def classes(self) -> Sequence[str]:
        """Names of the object classes; one bin each, unless the cell names its bins (`NamesBins`)."""

    @property
    def viewpoints(self) -> Sequence[str]:
        """Names of the viewpoints."""

    @property
    def layout(self) -> BeltLayout:
        """The belt's geometry."""

    @property
    def reject_bin(self) -> int | None:
        """The bin for undecided objects, or None if the cell has none."""
