"""The simulated cell with a belt that never stops, on a simulated clock."""

from collections.abc import Iterator, Sequence

import numpy as np

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.cell.protocols import Health, Scan
from beltsort.errors import CellError
from beltsort.geometry import BeltLayout, Points, Pose, look_at
from beltsort.sim.belt_drive import BeltDrive
from beltsort.sim.cell import SCAN_STREAM
from beltsort.sim.config import CellConfig
from beltsort.sim.noise import measured_points
from beltsort.sim.world import World
from beltsort.tracking.motion import EncoderReading
from beltsort.util.randomness import generator

PLACE_STREAM, ENCODER_STREAM, LABEL_STREAM = 7, 8, 9  # random streams, distinct from all others of a cell


class MovingCell:
    """A belt of bulbs in cups that moves while a structured-light camera on an arm looks at it.

    The belt moves whenever the clock does: during moves of the arm, exposures, and `wait`. Cup n enters
    upstream and leaves at the belt's end; its object and its place on the belt are functions of (`seed`, n),
    the errors of scan m of (`seed`, m). At speed 0, scans are those of a `SimulatedCell` with the same
    objects and seed whose belt has not advanced.

    Parameters
    ----------
    true_labels
        Class index of each object, None for an empty cup; cups after the last one are empty, unless `further`
        is given.
    belt
        How the belt moves.
    config
        Configuration of the cell. Of its durations `move_seconds` and `scan_seconds` are used.
    seed
        Seed, at least 0.
    further
        Class indices of the objects that follow, without end; None: the cups that follow are empty.

    Raises
    ------
    CellError
        If a true label is no class, or cups could touch.

    Attributes
    ----------
    clock
        Simulated time, seconds.

    Examples
    --------
    >>> cell = MovingCell([3, 0, None, 2], BeltDrive(belt_speed=0.1))
    >>> cell.wait(1.0)
    >>> round(cell.place(1), 6)
    0.08
    >>> cell.scan(not_before=0.0)
    Scan(480 x 640 points, camera 'camera' at (0.000, 0.634, 0.296) m, stamp 1.000 s)
    """

    def __init__(
        self,
        true_labels: Sequence[int | None],
        belt: BeltDrive | None = None,
        config: CellConfig | None = None,
        seed: int = 0,
        further: Iterator[int | None] | None = None,
    ) -> None:
        self.config = CellConfig() if config is None else config
        self.moving = BeltDrive() if belt is None else belt
        room = self.layout.spacing - 2.0 * self.layout.rim_radius - 6.0 * self.moving.pitch_jitter
        if self.moving.pitch_jitter > 0.0 and room <= 0.0:
            raise CellError(
                f"pitch_jitter is {self.moving.pitch_jitter} m, with which cups {self.layout.spacing} m "
                f"apart and {2.0 * self.layout.rim_radius} m wide could touch; expected "
                f"{room / 6.0 + self.moving.pitch_jitter:.3g} m at most"
            )
        empty = (
            None if generator(seed, LABEL_STREAM, n).random() < self.moving.empty else label
            for n, label in enumerate(true_labels)
        )
        self._world = World(
            list(empty) if self.moving.empty > 0.0 else true_labels, self.config, seed, further
        )
        self._seed = seed
        self._speeds = [(0.0, 0.0, self.moving.belt_speed)]  # time, travel, speed from then on
        self._arm = (0, 0, 0.0, 0.0)  # from viewpoint, to viewpoint, begin, end
        self._taken: set[int] = set()
        self._scans = self._readings = 0
        self._done: dict[str, tuple[int, float]] = {}
        self.clock = 0.0

    @property
    def classes(self) -> tuple[str, ...]:
        """Names of the object classes."""
        return self.config.classes

    @property
    def viewpoints(self) -> tuple[str, ...]:
        """Names of the viewpoints."""
        return tuple(v.name for v in self.config.viewpoints)

    @property
    def layout(self) -> BeltLayout:
        """Sizes of the cups, and their regular distance."""
        return self.config.layout

    def health(self) -> Health:
        """Return that the cell is ready."""
        return Health(ready=True, boot_id="simulated")

    def stop(self) -> None:
        """Stop the belt; the arm's simulated motions end by themselves."""
        self.set_speed(0.0)

    def true_class(self, index: int) -> int | None:
        """Return the class index of object `index`; None for an empty cup."""
        return self._world.true_class(index)

    def begin_at(self, clock: float, travel: float, *, viewpoint: int, scans: int) -> None:
        """Set the state at which a run is resumed; the belt moves with its configured speed.

        Parameters
        ----------
        clock
            Time of the cell's clock, seconds.
        travel
            How far the belt has moved, metres.
        viewpoint
            Where the camera stands.
        scans
            Number of scans that were taken, on which the noise of the next ones depends.
        """
        speed = self.moving.belt_speed
        self.clock, self._scans = clock, scans
        self._speeds = [(0.0, travel - speed * clock, speed)]
        self._arm = (viewpoint, viewpoint, 0.0, 0.0)

    def set_speed(self, belt_speed: float) -> None:
        """Set the belt's speed from now on, metres per second, at least 0."""
        if not 0.0 <= belt_speed < np.inf:
            raise CellError(f"belt_speed is {belt_speed}, expected a finite number of at least 0: correct it")
        self._speeds.append((self.clock, self.travel(self.clock), belt_speed))

    def travel(self, time: float) -> float:
        """Return how far the belt has moved since time 0, metres."""
        since, travel, speed = next(entry for entry in reversed(self._speeds) if entry[0] <= max(0.0, time))
        return travel + speed * (time - since)

    def place(self, index: int, time: float | None = None) -> float:
        """Return the true x of the cup of object `index` at a time, default now, metres."""
        jitter = 0.0
        if self.moving.pitch_jitter > 0.0:
            drawn = generator(self._seed, PLACE_STREAM, index).normal()
            jitter = self.moving.pitch_jitter * float(np.clip(drawn, -3.0, 3.0))
        regular = float(self.layout.centre(index)[0])
        return regular + jitter - self.travel(self.clock if time is None else time)

    def on_belt(self, time: float | None = None) -> dict[int, float]:
        """Return the x of each cup, by its number, that is within the simulated part of the belt, metres."""
        start, end = self._world.extent
        travel = self.travel(self.clock if time is None else time)
        spacing = self.layout.spacing
        first = max(0, int((start + travel) // spacing) - 1)
        last = int((end + travel) // spacing) + 1
        places = {number: self.place(number, time) for number in range(first, last + 1)}
        return {number: x for number, x in places.items() if start <= x < end}

    def wait(self, seconds: float) -> None:
        """Let time pass, and with it the belt."""
        if not 0.0 <= seconds < np.inf:
            raise CellError(f"seconds is {seconds}, expected a finite number of at least 0")
        self.clock += seconds

    def take(self, index: int) -> bool:
        """Take object `index` off the belt, as a sorter does; return whether there was one in its cup."""
        there = self.true_class(index) is not None and index not in self._taken
        self._taken.add(index)
        return there

    def encoder(self) -> EncoderReading:
        """Return a reading of the belt's encoder, of now."""
        rng = generator(self._seed, ENCODER_STREAM, self._readings)
        self._readings += 1
        error = self.moving.encoder_jitter * float(rng.normal())
        return EncoderReading(self.clock, self.moving.encoder_scale * self.travel(self.clock) + error)

    def start_move(self, viewpoint: int) -> float:
        """Start to move the camera to `viewpoint`; return the time at which it will stop, seconds.

        The belt moves on, and scans can be taken on the way. A move replaces one that has not ended.
        """
        if not 0 <= viewpoint < len(self.viewpoints):
            raise CommandError(
                f"viewpoint is {viewpoint}, expected an index from 0 to {len(self.viewpoints) - 1} "
                f"({', '.join(self.viewpoints)})",
                Outcome.NOT_DONE,
            )
        start = self._arm[1]
        self._arm = (start, viewpoint, self.clock, self.clock + self.config.seconds_of_move(start, viewpoint))
        return self._arm[3]

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Move the camera to `viewpoint`; return the time at which it stopped, seconds."""
        if command_id not in self._done:
            seconds = self.config.seconds_of_move(self._arm[1], viewpoint)
            if seconds > timeout:
                raise CommandError(
                    f"the move takes {seconds:g} s, expected at most the timeout of "
                    f"{timeout:g} s; give a longer one",
                    Outcome.NOT_DONE,
                )
            self._done[command_id] = (viewpoint, self.start_move(viewpoint))
            self.clock = self._done[command_id][1]
        earlier, stop = self._done[command_id]
        if earlier != viewpoint:
            raise CommandError(
                f"command id {command_id!r} belongs to a move to viewpoint {earlier}, got one to "
                f"{viewpoint}; give every command its own id",
                Outcome.NOT_DONE,
            )
        return stop

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command."""
        return Outcome.DONE if command_id in self._done else Outcome.NOT_DONE

    def pose(self, time: float) -> Pose:
        """Return the camera's pose at a time, as the arm reports it, belt frame, shape (4, 4).

        Between two viewpoints the camera moves along the shorter arc about the belt end, at constant speed,
        and looks at the belt end.
        """
        start, goal, begin, end = self._arm
        share = 1.0 if end <= begin else float(np.clip((time - begin) / (end - begin), 0.0, 1.0))
        a, b = self.config.viewpoints[start].pose(), self.config.viewpoints[goal].pose()
        return b if share >= 1.0 else a if share <= 0.0 else _between(a, b, share)

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan whose exposure began at or after `not_before`, seconds on the cell's clock.

        Its stamp is the time at which the exposure began, its pose the one that the arm reports for the
        middle of the exposure. The clock advances by `scan_seconds`, or by the exposure if that is longer.
        """
        if not np.isfinite(not_before):
            raise CellError(f"not_before is {not_before}, expected a time on the cell's clock; give a number")
        if not_before - self.clock > timeout:
            raise CommandError(
                f"waiting for the scan takes {not_before - self.clock:g} s, expected at most the timeout of "
                f"{timeout:g} s; give a longer one",
                Outcome.NOT_DONE,
            )
        self.clock = stamp = max(self.clock, not_before)
        rng = generator(self._seed, SCAN_STREAM, 0, self._scans)
        self._scans += 1
        middle = self.pose(stamp + self.moving.exposure / 2.0)
        points = self._exposed(stamp, rng)
        self.clock += max(self.config.scan_seconds, self.moving.exposure)
        return Scan(points, middle, stamp)

    def _exposed(self, stamp: float, rng: np.random.Generator) -> Points:
        """Return the points of a scan, camera frame, shape (height, width, 3)."""
        places = self.on_belt(stamp)
        if places:
            self._world.advance_to(min(places))
        scene = self._world.scene_with(places, self._taken)
        arm_errors = self.config.arm.true_pose(np.eye(4), rng)
        return measured_points(
            scene.rolling_view([pose @ arm_errors for pose in self._relative(stamp)]), self.config, rng
        )

    def _relative(self, stamp: float) -> Iterator[Pose]:
        """Yield the camera's pose at each slice's time, relative to the belt as it was at `stamp`."""
        end = stamp + self.moving.exposure
        moves = self.travel(end) > self.travel(stamp) or not np.array_equal(self.pose(stamp), self.pose(end))
        slices = self.moving.slices if moves else 1
        for n in range(slices):
            time = stamp + (n + 0.5) / slices * self.moving.exposure
            pose = self.pose(time).copy()
            pose[0, 3] += self.travel(time) - self.travel(stamp)
            yield pose


def _between(a: Pose, b: Pose, share: float) -> Pose:
    """Return the pose on the way from viewpoint `a` to `b`, both of which look at the belt end, (4, 4)."""
    eyes = a[:3, 3], b[:3, 3]
    radii = [float(np.linalg.norm(eye)) for eye in eyes]
    cosine = float(np.clip(eyes[0] @ eyes[1] / (radii[0] * radii[1]), -1.0, 1.0))
    angle = np.arccos(cosine)
    direction = eyes[0] / radii[0]
    if angle > 1e-9:
        weights = np.sin([(1.0 - share) * angle, share * angle]) / np.sin(angle)
        direction = weights[0] * eyes[0] / radii[0] + weights[1] * eyes[1] / radii[1]
    radius = (1.0 - share) * radii[0] + share * radii[1]
    return look_at(radius * direction, np.zeros(3))
