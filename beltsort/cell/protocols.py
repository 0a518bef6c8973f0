"""What a robot cell is: an arm that carries a depth camera, a belt, and a sorter.

The rules that every device keeps, so that nothing is lost or done twice:

* A call blocks until the act is done, and no longer than its `timeout` (seconds). Then, or when the act
  fails, it raises a `CommandError` that says the outcome: done, not done, or unknown.
* An actuator's command carries an id, unique for the device, under which it acts at most once. `outcome_of`
  tells what became of it, also after the connection or this program was restarted. A command that was broken
  off never acts again under its id: whoever repeats it gives it a new one.
* Targets are absolute: "object n at the belt end", never "one step further".
* A scan is younger than the stop of everything that moves. Both are given on the cell's clock: real devices
  use `time.monotonic`, so that no setting of the time of day changes their order; simulated ones have their
  own.
* Poses are in the robot's world; a cell that is composed of devices brings them into the belt's frame.
* A device whose controller was restarted has another `boot_id`: what it no longer remembers is unknown, not
  undone.

The emergency stop belongs to hardware. Software only reports it (`Health.emergency_stop`,
`EmergencyStopError`) and aborts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from beltsort.cell.commands import TIMEOUT, Outcome
from beltsort.geometry import BeltLayout, Points, Pose

NOWHERE = -1
"""The position of a belt that moves, stands between two objects, or was not told where it stands."""


@dataclass(frozen=True)
class Scan:
    """What the depth camera returns.

    Attributes
    ----------
    points
        Points in the *camera* frame, metres: (height, width, 3) for an organised depth image, NaN where a
        pixel has no return, or (n, 3).
    world_from_camera
        The camera's pose, shape (4, 4). A driver tells it in the robot's world, or NaN if it does not know
        it; a cell that is composed of drivers tells it in the belt's frame.
    stamp
        Time at which the exposure began, seconds on the cell's clock.
    frame
        Name of the camera frame.
    assumed
        Whether nobody knows where the camera stood: the pose is that of the viewpoint where it should.
    """

    points: Points
    world_from_camera: Pose
    stamp: float
    frame: str = "camera"
    assumed: bool = False


@dataclass(frozen=True)
class Health:
    """What a device says of itself.

    Attributes
    ----------
    ready
        Whether it takes commands.
    boot_id
        Changes when its controller restarts.
    fault
        Why it is not ready, in words; empty if it is.
    emergency_stop
        Whether the emergency stop is pressed.
    needs_home
        Whether it takes no commands until a person has told it which object is at the belt end
        (`Homing.home`).
    """

    ready: bool
    boot_id: str
    fault: str = ""
    emergency_stop: bool = False
    needs_home: bool = False


class Device(Protocol):
    """What every device can do."""

    def health(self) -> Health:
        """Say how it is. Raises `CommandError` if it cannot be reached."""

    def stop(self) -> None:
        """End every motion now, whatever becomes of its command. May be called from any thread."""


class Actuator(Device, Protocol):
    """A device that acts on commands."""

    def outcome_of(self, command_id: str, boot_id: str = "", /) -> Outcome:
        """Tell what became of a command; `NOT_DONE` for one that never arrived.

        `UNKNOWN` if the device may have forgotten what it did, after a restart for example.

        Parameters
        ----------
        command_id
            The command's.
        boot_id
            `Health.boot_id` from before it was sent; empty if that is not known.
        """


class Arm(Actuator, Protocol):
    """Carries the camera."""

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring the camera to `viewpoint`; return the time of its stop, seconds on the cell's clock."""


class DepthCamera(Device, Protocol):
    """Takes scans."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan whose exposure began at or after `not_before` (seconds on the cell's clock)."""


class Belt(Actuator, Protocol):
    """Carries the objects."""

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring object number `index` of the run to the belt end; return the time of its stop there.

        Seconds on the cell's clock.
        """


class Sorter(Actuator, Protocol):
    """Puts the object at the belt end into a bin."""

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into the bin of class `label`, or into the cell's `reject_bin`."""


@runtime_checkable
class Homing(Protocol):
    """A belt that a person must tell where it stands, when it does not know. Nothing else ever homes it."""

    def home(self, index: int, *, timeout: float = TIMEOUT) -> None:
        """Take it that object number `index` of the run is at the belt end."""


@runtime_checkable
class TellsPosition(Protocol):
    """A belt that knows where it stands."""

    def position(self) -> int | None:
        """Return the number of the object at the belt end.

        `NOWHERE` while the belt moves, stands between two objects, or was not told; None if it is not set up
        for that. Raises `CommandError` if it cannot be reached.
        """


@runtime_checkable
class Addressed(Protocol):
    """A device that only one run may drive at a time."""

    @property
    def address(self) -> str:
        """What names the device on this machine and its networks, such as `opc.tcp://192.168.0.5:4840`."""


@runtime_checkable
class TellsFlangePose(Protocol):
    """An arm that knows where its flange is."""

    def flange_pose(self, *, timeout: float = TIMEOUT) -> Pose | None:
        """Return the flange's pose in the robot's world, shape (4, 4), or None if it is not set up for that.

        Raises `CommandError` if the arm cannot be asked.
        """


@runtime_checkable
class KnowsPoses(Protocol):
    """A cell that knows where the camera should stand."""

    @property
    def poses(self) -> Sequence[Pose | None]:
        """The camera's pose at each viewpoint in the belt's frame, shape (4, 4), or None."""


@runtime_checkable
class NumbersBins(Protocol):
    """A cell whose sorter has numbers of its own for the bins."""

    @property
    def bin_numbers(self) -> Sequence[int]:
        """The sorter's number of each label's bin, of the reject bin's last; empty: the labels themselves."""


@runtime_checkable
class FollowsBelt(Protocol):
    """A simulated world that has no belt of its own in this cell."""

    def follow(self, index: int, stopped: float) -> None:
        """Have object number `index` at the belt end since `stopped`, seconds on the cell's clock."""


@runtime_checkable
class Restorable(Protocol):
    """A device whose world ends with the process that made it, such as a simulated one."""

    def restore(self, index: int, *, first: int, looks: int, taken: bool, clock: float) -> None:
        """Stand where a run begins, or broke off.

        Parameters
        ----------
        index
            Number of the object at the belt end.
        first
            Number of the first object of the run.
        looks
            Scans since it arrived there.
        taken
            Whether it has been sorted.
        clock
            Seconds on the cell's clock.
        """


class Cell(Protocol):
    """Arm, camera, belt and bins, and what they are set to. A device may be several of them at once."""

    @property
    def arm(self) -> Arm:
        """Carries the camera."""

    @property
    def camera(self) -> DepthCamera:
        """Takes scans."""

    @property
    def belt(self) -> Belt:
        """Carries the objects."""

    @property
    def sorter(self) -> Sorter:
        """Puts objects into bins."""

    @property
    def classes(self) -> Sequence[str]:
        """Names of the object classes, one bin each."""

    @property
    def viewpoints(self) -> Sequence[str]:
        """Names of the viewpoints."""

    @property
    def layout(self) -> BeltLayout:
        """The belt's geometry."""

    @property
    def reject_bin(self) -> int | None:
        """The bin for undecided objects, or None if the cell has none."""
