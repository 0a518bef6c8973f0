"""The sorting loop on a belt that never stops: scan, track, update beliefs, plan, divert."""

import logging
from pathlib import Path
from uuid import uuid4

import beltsort
from beltsort._core import DecideAt, Move, MovingBelt, Wait
from beltsort.cell import EmergencyStopError, Outcome
from beltsort.cell.diverting import BeltReading, DivertingCell
from beltsort.errors import CellError
from beltsort.planning.policy import MovingPolicy
from beltsort.sorting.ending import sort_to_end
from beltsort.sorting.fit import check_fit
from beltsort.sorting.heeding import Check, Heeding, nothing
from beltsort.sorting.holds import HeldError, Hold
from beltsort.sorting.journal import Journal
from beltsort.sorting.moving.belt import BeltWatch
from beltsort.sorting.moving.choosing import MovingChooser
from beltsort.sorting.moving.diverting import Diverter
from beltsort.sorting.moving.entries import Fate, MovingResumed, MovingStarted, ObjectLeft
from beltsort.sorting.moving.looking import Looker, PerceiveMoving
from beltsort.sorting.moving.reading import moving_state_in
from beltsort.sorting.moving.record import MovingRecord, Patience
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.moving.state import MovingState
from beltsort.sorting.rules import Rules

log = logging.getLogger(__name__)

SPEED_TOLERANCE = 0.2
"""Largest relative deviation of the belt's speed from the one that is planned for."""

SPEED_TICKS = 20
"""Most ticks in which the speed is measured when a run begins."""


def sort_moving(
    cell: DivertingCell,
    perceive: PerceiveMoving,
    policy: MovingPolicy,
    belt: MovingBelt,
    journal: Journal,
    *,
    objects: int | None,
    rules: Rules | None = None,
    check: Check = nothing,
    requests: Path | None = None,
) -> MovingReport:
    """Sort the next objects of a belt that never stops, journalling every step.

    A decision is a diversion, which the controller carries out when the object comes by. Every object that
    leaves the belt is journalled with what became of it. Whenever the run ends before all objects have left,
    by an error, an interrupt or a request, the belt is stopped, so that nothing passes unsorted; an operator
    starts it again. After a kill it moves on, and what has passed undecided is told when the run is resumed.

    Parameters
    ----------
    cell
        Arm, camera and belt; classes, viewpoints, bins and places must be the model's, in order. Objects, or
        cups, must stand at regular distances of the layout's `spacing`.
    perceive
        Finds, tracks and labels objects, such as `beltsort.tracking.TrackedPerception`.
    policy
        Chooses the next action.
    belt
        Model, times and prices; `seconds_per_tick` is needed.
    journal
        An open journal without entries.
    objects
        Number of objects, empty cups included; None: until a request to stop.
    rules
        Limits, of which `empty_looks`, `scan_attempts` and `retry_delays` are used.
    check
        Called before every step; an exception that it raises ends the run.
    requests
        Folder of requests to hold, to continue and to stop the run.

    Raises
    ------
    CellError
        If cell and model do not fit, or a device fails; `HeldError` if it may be tried again, and
        `EmergencyStopError`.
    BeltsortError
        Any other error of perception or of the policy.
    """
    record = MovingRecord(journal, MovingState(belt))
    loop = _MovingLoop(cell, perceive, policy, record, rules or Rules(), check, requests)
    return loop.run(
        MovingStarted(
            run=uuid4().hex[:8], objects=objects, belt=belt.to_json(), beltsort=beltsort.__version__
        )
    )


def resume_moving(
    cell: DivertingCell,
    perceive: PerceiveMoving,
    policy: MovingPolicy,
    journal: Journal,
    *,
    rules: Rules | None = None,
    check: Check = nothing,
    requests: Path | None = None,
) -> MovingReport:
    """Continue an interrupted run from its journal.

    The controller is asked what became of every diversion. If it was not restarted, coordinates and beliefs
    of objects hold; those that have passed the exit undecided are told as missed. If it was restarted, every
    object that was on the belt is told as lost, or unknown if it was decided, and those still there get new
    numbers.

    Parameters
    ----------
    cell, perceive, policy, rules, check, requests
        As in `sort_moving`.
    journal
        The run's journal, opened with ``resume=True``.

    Raises
    ------
    JournalError
        If the journal is damaged, or of a belt that stops.
    BeltsortError
        As `sort_moving`.
    """
    record = MovingRecord(journal, moving_state_in(journal.path))
    loop = _MovingLoop(cell, perceive, policy, record, rules or Rules(), check, requests)
    return loop.run(MovingResumed(belt=record.state.belt.to_json(), beltsort=beltsort.__version__))


class _MovingLoop:
    def __init__(
        self,
        cell: DivertingCell,
        perceive: PerceiveMoving,
        policy: MovingPolicy,
        record: MovingRecord,
        rules: Rules,
        check: Check,
        requests: Path | None,
    ) -> None:
        self.cell, self.record, self.state = cell, record, record.state
        self.rules, self.check = rules, check
        self.heed = Heeding(requests, record, check, pause=cell.wait, before=cell.belt.stop)
        self.tick = _checked(cell, self.state.belt)
        self.patience = Patience(rules.retry_delays, cell.wait, check)
        self.watch = BeltWatch(cell.belt, self.patience, record, cell.layout.spacing)
        self.looker = Looker(cell, perceive, self.watch, record, rules, self.patience)
        self.diverter = Diverter(cell, record, self.patience)
        self.chooser = MovingChooser(policy, record, self.tick)
        self.standing = False

    def run(self, first: MovingStarted | MovingResumed) -> MovingReport:
        """Write the first entry, take steps until all objects have left, and journal how it ended."""
        stop = sort_to_end(self.record, first, self.cell, self, self.begin)
        return MovingReport.of(self.state, None if stop is None else stop.by)

    @property
    def done(self) -> bool:
        """Whether all objects have left the belt."""
        return self.state.done

    def begin(self) -> None:
        """Bring the camera to where the run has it, and check the belt's speed."""
        self.looker.move(self.state.viewpoint)
        self.check_speed()

    def step(self) -> None:
        """Tell what has left, follow the diversions, and take the policy's next action."""
        reading = self.read()
        if self.state.boot_id != reading.boot_id:
            self.begin_anew()
            return
        at_exit = self.state.numbers(reading.travel).start
        self.tell_passed(at_exit)
        self.diverter.follow(at_exit)
        if not reading.moving:
            self.wait_for_belt()
            return
        self.standing = False
        belief = self.state.belief(reading.travel, self.rules.empty_looks)
        if self.state.done or belief.is_over:
            self.cell.wait(self.tick)
            return
        match self.chooser.choose(belief):
            case Move(viewpoint):
                self.look_from(viewpoint, reading.stamp)
            case DecideAt(position, bin):
                self.diverter.decide(self.state.numbers(reading.travel)[position], bin)
            case Wait():
                self.cell.wait(self.tick)

    def look_from(self, viewpoint: int, started: float) -> None:
        """Move the camera, and scan no earlier than the policy has planned.

        A scan that came earlier would see objects where the last one has seen them, and tell nothing new.

        Parameters
        ----------
        viewpoint
            Where to look from.
        started
            When the action began, seconds on the cell's clock.
        """
        ticks = int(self.state.belt.look_ticks[self.state.viewpoint][viewpoint])
        if viewpoint != self.state.viewpoint:
            self.looker.move(viewpoint)
        early = started + ticks * self.tick - self.read().stamp
        if early > 0.0:
            self.cell.wait(early)
        self.looker.look()

    def read(self) -> BeltReading:
        """Return a new reading of the belt.

        Raises
        ------
        EmergencyStopError
            If the emergency stop is pressed.
        """
        reading = self.watch.read()
        if reading.emergency_stop:
            raise EmergencyStopError(
                "the emergency stop of the belt is pressed; release it at the machine, start the belt, then "
                "resume",
                Outcome.NOT_DONE,
            )
        return reading

    def begin_anew(self) -> None:
        """Tell the objects whose coordinates are void, and look until a cup is seen."""
        if self.state.boot_id:
            self.diverter.close(max([self.state.settled, *(number + 1 for number in self.state.on_belt)]))
        if not self.state.done:
            self.looker.look()
            if self.state.boot_id != self.watch.read().boot_id:
                self.cell.wait(self.tick)

    def tell_passed(self, at_exit: int) -> None:
        """Journal the objects that have passed the exit undecided, and the empty cups, in order."""
        state = self.state
        end = at_exit if state.objects is None else min(at_exit, state.objects)
        for number in range(state.settled, end):
            if number < state.settled:
                continue  # it was decided, and was settled with the one before
            known = state.known(number)
            if state.is_empty(known, self.rules.empty_looks):
                self.record(ObjectLeft(number, Fate.EMPTY))
            else:
                looks = f"after {known.looks} looks" if known.looks else "unseen"
                self.record(ObjectLeft(number, Fate.MISSED, f"it passed the exit undecided, {looks}"))
        for number, known in list(state.on_belt.items()):
            if known.skipped and number < at_exit:
                self.record(ObjectLeft(number, Fate.EMPTY))

    def check_speed(self) -> None:
        """Check that the belt moves as fast as the policy assumes, if it moves.

        Clocks may be known so badly at first that some ticks are needed to tell.

        Raises
        ------
        HeldError
            If it is faster or slower by more than `SPEED_TOLERANCE`.
        """
        spacing, per_place = self.cell.layout.spacing, self.state.belt.ticks_per_place or 1
        planned = spacing / (per_place * self.tick)
        before = self.read()
        for _ in range(SPEED_TICKS):
            self.cell.wait(self.tick)
            after = self.read()
            seconds, unsure = after.stamp - before.stamp, before.error + after.error
            if not (before.moving and after.moving and after.boot_id == before.boot_id) or seconds <= 0.0:
                return
            way = after.travel - before.travel
            least, most = way / (seconds + unsure), way / max(seconds - unsure, 1e-9)
            if least > (1.0 + SPEED_TOLERANCE) * planned or most < (1.0 - SPEED_TOLERANCE) * planned:
                speed = way / seconds
                raise HeldError(
                    Hold(
                        None,
                        f"the belt moves at {speed:.3f} m/s, expected about {planned:.3f} m/s: a place of "
                        f"{spacing:g} m in {per_place} ticks of {self.tick:g} s; set the belt's speed, or "
                        "correct ticks_per_place or seconds_per_tick",
                        person=True,
                    )
                )
            if least > (1.0 - SPEED_TOLERANCE) * planned and most < (1.0 + SPEED_TOLERANCE) * planned:
                return

    def wait_for_belt(self) -> None:
        """Wait a tick while the belt stands."""
        if not self.standing:
            log.warning("the belt stands; an operator starts it")
        self.standing = True
        self.cell.wait(self.tick)


def _checked(cell: DivertingCell, belt: MovingBelt) -> float:
    """Return the seconds of a tick, after checking that cell and model fit."""
    check_fit(cell, belt.model)
    if belt.ticks_per_place is None:
        raise CellError(
            "the belt of the model advances on decisions (advance_ticks), expected one of constant "
            "speed: give ticks_per_place, or sort with `sort_objects`"
        )
    if belt.seconds_per_tick is None:
        raise CellError(
            "seconds_per_tick of the moving belt is missing, expected the time of a tick: give "
            "MovingBelt(..., seconds_per_tick=0.5) the cell's"
        )
    return float(belt.seconds_per_tick)
