"""The simulated cell: all four devices, on a simulated clock."""

from collections.abc import Callable, Iterator, Sequence
from typing import Self

import numpy as np

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.cell.placement import Placement
from beltsort.cell.protocols import Health, Scan
from beltsort.errors import CellError
from beltsort.geometry import BeltLayout, Pose
from beltsort.sim.config import CellConfig
from beltsort.sim.noise import measured_points
from beltsort.sim.world import World
from beltsort.util.randomness import generator

SCAN_STREAM = 1  # random stream of scans, distinct from that of objects


class SimulatedCell:
    """A belt of bulbs in cups, a structured-light camera on an arm, and bins.

    Object n of the run is of class `true_labels[n]`. Its size and pose are a function of (`seed`, n), and do
    not change until it is sorted; the errors of a scan are a function of (`seed`, object at the belt end,
    number of scans since it arrived). Neither depends on earlier actions, so that policies are compared with
    the same objects and noise.

    Parameters
    ----------
    true_labels
        Class index of each object of the run, None for an empty cup. All cups after the last one are empty,
        unless there are `further` ones.
    config
        Configuration of the cell.
    seed
        Seed, at least 0.
    placement
        Transforms between belt, robot's world and flange; poses are reported in the robot's world frame.
    bin_names
        Names of the bins; those of the classes by default.
    reject_bin
        Index of the bin for undecided objects; that of the configuration by default.
    further
        Class indices of the objects after those of `true_labels`, without end.

    Raises
    ------
    CellError
        If a true label is no class, or the reject bin is one of the bins.

    Attributes
    ----------
    bins
        The objects sorted so far, in order: (object number, index of the bin).
    bin_names
        Names of the bins, without the reject bin.
    clock
        Simulated time, seconds.

    Examples
    --------
    >>> cell = SimulatedCell([3, 0, None, 2], seed=1)
    >>> scan = cell.scan(not_before=cell.move_to(1, "move-0"))
    >>> scan.points.shape
    (480, 640, 3)
    >>> cell.sort(3, "sort-0")
    >>> cell.bins
    [(0, 3)]
    """

    def __init__(
        self,
        true_labels: Sequence[int | None],
        config: CellConfig | None = None,
        seed: int = 0,
        placement: Placement | None = None,
        bin_names: Sequence[str] | None = None,
        reject_bin: int | None = None,
        further: Iterator[int | None] | None = None,
    ) -> None:
        self._config = CellConfig() if config is None else config
        self.bin_names = tuple(self._config.classes if bin_names is None else bin_names)
        self._reject_bin = self._config.reject_bin if reject_bin is None else reject_bin
        if self.reject_bin is not None and self.reject_bin < len(self.bin_names):
            raise CellError(
                f"reject_bin is {self.reject_bin}, expected None or at least {len(self.bin_names)}, the "
                f"number of bins ({', '.join(self.bin_names)}); choose another"
            )
        self._world = World(true_labels, self._config, seed, further)
        self._seed, self._placement = seed, placement or Placement()
        self._done: dict[str, tuple[tuple[str, int], float]] = {}
        self._viewpoint, self._looks = 0, 0
        self.clock = 0.0
        self.bins: list[tuple[int, int]] = []

    @property
    def config(self) -> CellConfig:
        """Configuration of the cell."""
        return self._config

    @property
    def classes(self) -> tuple[str, ...]:
        """Names of the object classes."""
        return self._config.classes

    @property
    def viewpoints(self) -> tuple[str, ...]:
        """Names of the viewpoints."""
        return tuple(v.name for v in self._config.viewpoints)

    @property
    def poses(self) -> tuple[Pose, ...]:
        """The camera's pose at each viewpoint in the belt frame, shape (4, 4)."""
        return tuple(v.pose() for v in self._config.viewpoints)

    @property
    def layout(self) -> BeltLayout:
        """The belt's geometry."""
        return self._config.layout

    @property
    def reject_bin(self) -> int | None:
        """The bin for undecided objects, or None if the cell has none."""
        return self._reject_bin

    @property
    def arm(self) -> Self:
        """The cell itself."""
        return self

    @property
    def camera(self) -> Self:
        """The cell itself."""
        return self

    @property
    def belt(self) -> Self:
        """The cell itself."""
        return self

    @property
    def sorter(self) -> Self:
        """The cell itself."""
        return self

    def health(self) -> Health:
        """Return that the cell is ready."""
        return Health(ready=True, boot_id="simulated")

    def stop(self) -> None:
        """Do nothing: simulated motions end within the call."""

    def position(self) -> int:
        """Return the number of the object at the belt end."""
        return self._world.first

    def true_class(self, index: int) -> int | None:
        """Return the class index of object `index`; None for an empty cup."""
        return self._world.true_class(index)

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command."""
        return Outcome.DONE if command_id in self._done else Outcome.NOT_DONE

    def follow(self, index: int, stopped: float) -> None:
        """Set the object at the belt end to `index`, as brought there by a belt of another back-end."""
        self.clock = max(self.clock, stopped)
        if self._world.steps_to(index) > 0:
            self._world.advance_to(index)
            self._looks = 0

    def restore(self, index: int, *, first: int, looks: int, taken: bool, clock: float) -> None:
        """Restore the state of an interrupted run: see `beltsort.cell.protocols.Restorable`."""
        self._world.start = first
        self._world.advance_to(index)
        if taken:
            self._world.remove_object()
        self._looks, self.clock = looks, clock

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Move the camera to `viewpoint`; return the time at which it stopped, seconds."""
        if not 0 <= viewpoint < len(self.viewpoints):
            raise CommandError(
                f"viewpoint is {viewpoint}, expected an index from 0 to {len(self.viewpoints) - 1} "
                f"({', '.join(self.viewpoints)})",
                Outcome.NOT_DONE,
            )

        def move() -> None:
            self._spend("the move", self._config.seconds_of_move(self._viewpoint, viewpoint), timeout)
            self._viewpoint = viewpoint

        return self._once(("move_to", viewpoint), command_id, move)

    def flange_pose(self, **_timeout: float) -> Pose | None:
        """Return the flange's pose in the robot's world frame, shape (4, 4), or None if it is not known."""
        return self._placement.of_flange(self._pose())

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan whose exposure began at or after `not_before` (seconds on the cell's clock)."""
        if not np.isfinite(not_before):
            raise CellError(f"not_before is {not_before}, expected a time on the cell's clock; give a number")
        self._spend("waiting for the scan", max(0.0, not_before - self.clock), timeout)
        stamp = self.clock
        rng = generator(self._seed, SCAN_STREAM, self._world.first, self._looks)
        self._looks += 1
        self.clock += self._config.scan_seconds
        reported = self._pose()
        view = self._world.scene().view(self._config.arm.true_pose(reported, rng))
        points = measured_points(view, self._config, rng)
        return Scan(points, self._placement.in_world(reported), stamp)

    def _pose(self) -> Pose:
        """Return the camera's pose in the belt frame as reported by the arm, shape (4, 4)."""
        return self._config.viewpoints[self._viewpoint].pose()

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into bin `label`, an index into `bin_names`, or into `reject_bin`.

        If the cup is empty, nothing is put into a bin.
        """
        if not 0 <= label < len(self.bin_names) and label != self.reject_bin:
            raise CommandError(
                f"label is {label}, expected a bin from 0 to {len(self.bin_names) - 1} "
                f"({', '.join(self.bin_names)}) or the reject bin ({self.reject_bin})",
                Outcome.NOT_DONE,
            )

        def sort() -> None:
            self._world.check_not_sorted()
            self._spend("the sort", self._config.sort_seconds, timeout)
            number = self._world.first
            if self._world.remove_object():
                self.bins.append((number, label))

        self._once(("sort", label), command_id, sort)

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring object `index` to the belt end; return the time at which the belt stopped.

        The time is in seconds on the cell's clock. Objects that pass the belt end unsorted are lost. The
        index after the last object is valid, and leaves only empty cups.
        """

        def advance() -> None:
            steps = self._world.steps_to(index)
            self._spend("the advance", self._config.advance_seconds * steps, timeout)
            if steps > 0:
                self._world.advance_to(index)
                self._looks = 0

        return self._once(("advance_to", index), command_id, advance)

    def _once(self, command: tuple[str, int], command_id: str, act: Callable[[], None]) -> float:
        """Execute a command unless its id was executed before; return the time at which it ended."""
        if command_id not in self._done:
            act()
            self._done[command_id] = (command, self.clock)
        earlier, time = self._done[command_id]
        if earlier != command:
            raise CommandError(
                f"command id {command_id!r} belongs to {earlier[0]}({earlier[1]}), expected the same command "
                f"again, got {command[0]}({command[1]}); give every command its own id",
                Outcome.NOT_DONE,
            )
        return time

    def _spend(self, what: str, seconds: float, timeout: float) -> None:
        """Advance the simulated clock, unless the duration exceeds the timeout."""
        if seconds > timeout:
            raise CommandError(
                f"{what} takes {seconds:g} s, expected at most the timeout of {timeout:g} s; give a longer "
                "one",
                Outcome.NOT_DONE,
            )
        self.clock += seconds
