"""Moving the camera, and scans of the moving belt: labels of its objects, and beliefs from them."""

import math
from collections.abc import Sequence
from functools import partial
from typing import Protocol

from beltsort._core import ImpossibleObservationError, MovingBelief
from beltsort.cell import CommandError, EmergencyStopError, Outcome, Scan
from beltsort.cell.commands import MoveTo
from beltsort.cell.diverting import DivertingCell
from beltsort.errors import CloudError, TrackingError
from beltsort.sorting.command import Command
from beltsort.sorting.entries import CommandDone, CommandFailed, Intended, ScanUnusable
from beltsort.sorting.holds import HeldError, Hold
from beltsort.sorting.moving.belt import BeltWatch
from beltsort.sorting.moving.entries import Anchored, Looked, SeenObject
from beltsort.sorting.moving.lattice import Lattice
from beltsort.sorting.moving.record import MovingRecord, Patience
from beltsort.sorting.perceived import LabelNumbers
from beltsort.sorting.rules import Rules
from beltsort.tracking import TrackedLook, TrackedScan, Tracker


class PerceiveMoving(Protocol):
    """Perception on a moving belt, such as `beltsort.tracking.TrackedPerception`."""

    @property
    def labels(self) -> Sequence[str]:
        """Names of the labels; labels are indices into them."""

    def __call__(self, scan: Scan, tracker: Tracker) -> TrackedScan:
        """Find the objects in a scan, label them, and update their tracks."""


class Looker:
    """Moves the camera and takes scans.

    Parameters
    ----------
    cell
        The cell; its arm and camera are used.
    perceive
        Finds and labels objects.
    watch
        The belt's motion and tracks.
    record
        Writes entries and applies them to the run's state.
    rules
        Limits.
    patience
        Repeats a move that failed.

    Raises
    ------
    CellError
        If the labels of perception are not the model's.
    """

    def __init__(
        self,
        cell: DivertingCell,
        perceive: PerceiveMoving,
        watch: BeltWatch,
        record: MovingRecord,
        rules: Rules,
        patience: Patience,
    ) -> None:
        self._cell, self._perceive, self._watch, self._record = cell, perceive, watch, record
        self._rules, self._patience = rules, patience
        self._labels = LabelNumbers(perceive, record.state.belt.model)
        self._stopped = float("-inf")
        self._unusable = 0

    def move(self, viewpoint: int) -> None:
        """Move the camera; a move may be repeated after any failure, since its target is absolute.

        Raises
        ------
        HeldError
            If it failed after every delay of `Rules.retry_delays`.
        EmergencyStopError
            If the emergency stop is pressed.
        """
        self._patience(partial(self._move, viewpoint))

    def _move(self, viewpoint: int) -> None:
        """Move the camera, and journal what comes of it."""
        arm, state = self._cell.arm, self._record.state
        boot_id = arm.health().boot_id
        command = Command(f"{state.run}-move-{state.commands + 1}", MoveTo(viewpoint), boot_id)
        self._record(Intended(command))
        try:
            self._stopped = arm.move_to(viewpoint, command.id)
        except CommandError as failure:
            self._record(CommandFailed(command.id, failure.outcome.value, repr(failure)))
            raise
        except BaseException as interrupt:
            self._record(CommandFailed(command.id, Outcome.UNKNOWN.value, repr(interrupt)))
            raise
        self._record(CommandDone(command.id, stopped=self._stopped))

    def look(self) -> None:
        """Take a scan from where the camera stands, and update what is known of the objects in it.

        A scan that cannot be used is journalled, and changes nothing.

        Raises
        ------
        HeldError
            If `Rules.scan_attempts` scans in a row cannot be used.
        EmergencyStopError
            If the emergency stop is pressed.
        """
        self._watch.read()
        try:
            scan = self._cell.camera.scan(not_before=self._stopped)
            if scan.stamp < self._stopped:
                raise CloudError(
                    f"the scan is of {scan.stamp:.3f} s, before the stop at {self._stopped:.3f} s; set the "
                    "clocks"
                )
            boot_id = self._watch.read().boot_id
            seen = self._perceive(scan, self._watch.tracker)
        except EmergencyStopError:
            raise
        except (CloudError, CommandError, TrackingError) as reason:
            self._record(ScanUnusable(str(reason)))
            self._unusable += 1
            if self._unusable >= self._rules.scan_attempts:
                raise HeldError(
                    Hold(
                        None,
                        f"{self._unusable} scans in a row are unusable, expected a point cloud; check the "
                        f"camera ({reason})",
                    )
                ) from reason
            return
        self._unusable = 0
        self._use(seen, boot_id)

    def _use(self, seen: TrackedScan, boot_id: str) -> None:
        """Journal what a scan has shown."""
        state, stamp = self._record.state, seen.update.stamp
        travel = self._watch.motion.travel(stamp).metres
        if state.boot_id != boot_id:
            cups = [look.place + travel for look in seen.looks]
            if not cups:
                return
            spacing = self._cell.layout.spacing
            # What has passed since the controller was started anew gets numbers too, and is told as missed.
            unseen = int(travel / spacing) if state.boot_id else 0
            first = max([state.settled, *(number + 1 for number in state.on_belt)]) + unseen
            lattice = Lattice.through(cups, travel, spacing, first)
            uncounted = self._uncounted(stamp, travel)
            self._record(Anchored(boot_id, lattice.spacing, lattice.origin, first, uncounted))
        objects = self._objects(seen, travel)
        events = [type(event).__name__ for event in seen.update.events]
        self._record(Looked(state.viewpoint, stamp, travel, objects, events))

    def _uncounted(self, stamp: float, travel: float) -> int:
        """Return how many objects may have passed between the last scan and the controller's new start.

        How far the belt has moved in that time, nobody knows: at most as far as it moves without a stop, be
        it that somebody has started it while the run was down. Those that were seen before, and are told
        already, are not counted again. If the clock began anew, as after a restart of this computer, the time
        counts from there.

        Parameters
        ----------
        stamp, travel
            Time and travel of the first scan since, seconds on the cell's clock and metres.
        """
        state, spacing = self._record.state, self._cell.layout.spacing
        belt = state.belt
        if state.watched is None or state.lattice is None:
            return 0
        place = float(belt.seconds_per_tick or 0.0) * (belt.ticks_per_place or 1)  # seconds
        since = state.watched if state.watched <= stamp else 0.0
        away = stamp - since - travel / spacing * place
        return max(0, math.ceil(away / place) - (state.settled - state.watched_exit))

    def _objects(self, seen: TrackedScan, travel: float) -> list[SeenObject]:
        """Return what a scan has shown of each object that is not settled, by number."""
        state = self._record.state
        tracks = {track.id: track.position for track in self._watch.tracker.tracks}
        numbers = state.numbers(travel)
        lattice = state.lattice
        assert lattice is not None
        nearest: dict[int, tuple[float, TrackedLook, float]] = {}
        for look in seen.looks:
            coordinate = look.place + travel
            if look.track is not None:
                coordinate = tracks.get(look.track, coordinate)
            number = lattice.number(coordinate)
            off = abs(coordinate - lattice.coordinate(number))
            if number not in numbers or state.is_settled(number):
                continue
            if number not in nearest or off < nearest[number][0]:
                nearest[number] = off, look, coordinate
        belief = state.belief(travel)
        return [
            self._updated(belief, number - numbers.start, number, look, coordinate)
            for number, (_, look, coordinate) in sorted(nearest.items())
        ]

    def _updated(
        self, belief: MovingBelief, place: int, number: int, look: TrackedLook, coordinate: float
    ) -> SeenObject:
        """Return what a scan shows of one object, and its belief after that (eq. 7)."""
        finding, label = str(look.perceived.finding), self._labels.of(look.perceived)
        if label is None:
            return SeenObject(number, coordinate, None, finding)
        labels: list[int | None] = [None] * len(belief.kinds)
        labels[place] = label
        try:
            belief.observe(self._record.state.viewpoint, labels)
        except ImpossibleObservationError:
            return SeenObject(number, coordinate, None, finding, dropped=label)
        return SeenObject(number, coordinate, label, finding, [float(p) for p in belief.kinds[place]])
