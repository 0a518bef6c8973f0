"""The loop: scan -> perceive -> belief -> plan -> act -> journal."""

from typing import TYPE_CHECKING, Any
from uuid import uuid4

import beltsort
from beltsort._core import Decide, Despot, Move, PolicyError, SortingModel
from beltsort.cell import Cell, EmergencyStopError
from beltsort.cell.stopping import stopping
from beltsort.commander import Commander, Operator, nobody
from beltsort.errors import CellError
from beltsort.journal import Journal
from beltsort.observing import Observer, Perceive, PerceivedPosition
from beltsort.packml import State
from beltsort.policy import Policy
from beltsort.progress import Owed, Progress
from beltsort.record import Record, progress_in
from beltsort.report import SortingReport
from beltsort.rules import Rules

if TYPE_CHECKING:
    from beltsort.tables import DriftWatch

__all__ = ["Perceive", "PerceivedPosition", "resume_sorting", "sort_objects"]


LATE = 1.2
"""A plan that took so many times its budget of time is marked in the journal; it is the best one so far."""


def sort_objects(
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    model: SortingModel,
    journal: Journal,
    *,
    objects: int,
    rules: Rules | None = None,
    operator: Operator = nobody,
    watch: "DriftWatch | None" = None,
) -> SortingReport:
    """Sort the next objects of the belt, journalling every step.

    Parameters
    ----------
    cell
        Arm, camera, belt and bins; its classes, viewpoints and positions must be the model's. It needs no bin
        for the model's class for empty cups if that is the last one.
    perceive
        From a scan to one result per position, the belt end first.
    policy
        Names the next action.
    model
        Updates the belief.
    journal
        An open journal without entries. Its last entry is `end`, also after an error or an interrupt; after a
        kill or a power cut there is none.
    objects
        Belt places to work through, object 0 standing at the belt end now. An empty one is skipped: when
        `Rules.empty_looks` says so or, if the model has a class for empty cups, when that is decided.
    rules
        Limits; default `Rules()`.
    operator
        Asked what became of a command where no device can tell; by default the run ends as held.
    watch
        Sees every scan; its alarms are journalled as `drift`, and the run goes on.

    Raises
    ------
    CellError
        If cell and model do not fit, the camera gives no usable scan, or a command cannot be carried out;
        `resume_sorting` goes on once that is mended.
    HeldError
        If a person must tell what became of a command.
    BeltsortError
        Whatever else the cell, perception or the policy raise.
    """
    record = Record(journal, Progress.at_start(model))
    loop = _Loop(cell, perceive, policy, record, rules or Rules(), operator, watch)
    return loop.run(
        "start",
        run=uuid4().hex[:8],
        objects=objects,
        model=model.to_json(),
        planner=_settings(policy),
        beltsort=beltsort.__version__,
    )


def resume_sorting(
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    journal: Journal,
    *,
    rules: Rules | None = None,
    operator: Operator = nobody,
    watch: "DriftWatch | None" = None,
) -> SortingReport:
    """Go on with a run that was broken off, wherever that was.

    The belief is exactly the one that the run had. A command whose outcome was not written down is settled
    first: a sort is repeated only if its device says that it was not done. The camera is brought back to
    where it stood, which counts as no step.

    Parameters
    ----------
    cell, perceive, policy, rules, operator, watch
        As in `sort_objects`; the same as before, if the decisions are to be the same.
    journal
        The run's journal, opened with ``resume=True``.

    Returns
    -------
    SortingReport
        Of the whole run, as far as the journal still tells of it.

    Raises
    ------
    JournalError
        If the journal is damaged.
    BeltsortError
        As `sort_objects`.
    """
    record = Record(journal, progress_in(journal.path))
    loop = _Loop(cell, perceive, policy, record, rules or Rules(), operator, watch)
    return loop.run(
        "resume",
        objects=record.progress.objects,
        model=record.progress.model.to_json(),
        planner=_settings(policy),
        beltsort=beltsort.__version__,
    )


class _Loop:
    def __init__(
        self,
        cell: Cell,
        perceive: Perceive,
        policy: Policy,
        record: Record,
        rules: Rules,
        operator: Operator,
        watch: "DriftWatch | None",
    ) -> None:
        self.cell, self.policy, self.record, self.rules = cell, policy, record, rules
        self.progress = record.progress
        self.model = self.progress.model
        _check_fit(cell, self.model)
        self.commander = Commander(cell, self.progress, record, rules, operator)
        self.observer = Observer(cell.camera, perceive, self.progress, record, rules, watch)

    def run(self, kind: str, **data: Any) -> SortingReport:
        """Work until nothing is left, from a first entry on; write down how it ends.

        What ends it early stops every device.
        """
        try:
            with stopping(self.cell):
                self.record(kind, **data)
                self.record("state", state=State.EXECUTE, reason=kind)
                while not self.progress.done:
                    self.step()
        except BaseException as failure:
            self.record("state", state=_state_after(failure), reason=repr(failure))
            self.record("end", reason=repr(failure))
            raise
        self.record("state", state=State.COMPLETE, reason="all objects have left the belt")
        self.record("end", reason="done")
        progress = self.progress
        return SortingReport(progress.steps, tuple(progress.decisions), tuple(progress.skipped))

    def step(self) -> None:
        """Do what is owed."""
        progress = self.progress
        if progress.pending is not None:
            self.commander.settle(progress.pending)
        elif not progress.arrived:
            self.commander.issue("move", progress.viewpoint, arriving=True)
        elif progress.owed is Owed.SCAN:
            self.observer.observe()
        elif progress.bin is not None:
            self.commander.issue("sort", progress.bin)
        elif progress.owed is Owed.ADVANCE:
            self.commander.issue("advance", progress.index + 1)
        else:
            self.choose()

    def choose(self) -> None:
        """Skip an empty place, decide where a rule says so, or do what the policy names."""
        belt_end, (most_likely, _) = self.progress.visible[0], self.progress.belief.most_likely(0)
        if self.known_empty():
            self.skip(decided=False)
        elif confirming := self.confirmation():
            self.commander.issue("move", confirming.viewpoint)
        elif belt_end.looks >= self.rules.max_looks:
            self.decide(most_likely, forced="max_looks")
        elif belt_end.impossible >= self.rules.impossible_labels:
            self.decide(most_likely, forced="impossible_labels")
        else:
            self.follow_policy()

    def follow_policy(self) -> None:
        """Plan, and do it."""
        match self.plan():
            case Move(viewpoint):
                self.commander.issue("move", viewpoint)
            case Decide(label):
                self.decide(label)

    def known_empty(self) -> bool:
        """Whether the rule of `empty_looks` says that the belt end is empty."""
        reachable = self.model.travel[self.progress.viewpoint]
        return self.model.empty is None and self.progress.visible[0].known_empty(self.rules, reachable)

    def confirmation(self) -> Move | None:
        """Return the move that would confirm an empty belt end, to a viewpoint not tried yet if possible."""
        tried = self.progress.visible[0].empty
        legal = self.model.travel[self.progress.viewpoint]
        if self.model.empty is not None or not tried or not legal:
            return None
        move = Move(min(legal, key=lambda viewpoint: (viewpoint in tried, viewpoint)))
        self.record("plan", action=_plain(move), why="the belt end was seen empty: look again")
        return move

    def plan(self) -> Move | Decide:
        """Ask the policy."""
        belief, viewpoint = self.progress.belief, self.progress.viewpoint
        if not isinstance(self.policy, Despot):
            action = self.policy.act(belief.copy(), viewpoint)
            self.check_legal(action)
            self.record("plan", action=_plain(action))
            return action
        plan = self.policy.plan(belief, viewpoint)
        self.record(
            "plan",
            action=_plain(plan.action),
            values=[{**_plain(action), "value": value} for action, value in plan.values.items()],
            lower=plan.lower,
            upper=plan.upper,
            trials=plan.trials,
            seconds=plan.seconds,
            late=plan.seconds > LATE * (self.policy.settings["seconds"] or float("inf")),
        )
        return plan.action

    def check_legal(self, action: object) -> None:
        """Refuse what the model does not allow, before anything moves."""
        moves = [Move(viewpoint) for viewpoint in self.model.travel[self.progress.viewpoint]]
        legal = [*moves, *(Decide(label) for label in range(len(self.model.classes)))]
        if action not in legal:
            raise PolicyError(
                f"the policy returned {action!r} at viewpoint {self.progress.viewpoint}; legal are {legal}"
            )

    def decide(self, label: int, forced: str | None = None) -> None:
        """Write down where the object at the belt end goes; an empty cup goes nowhere."""
        rejected = self.cell.reject_bin if forced is not None else None
        if self.model.classes[label] == self.model.empty and rejected is None:
            self.skip(decided=True)
            return
        self.record(
            "decision",
            label=label if rejected is None else None,
            bin=label if rejected is None else rejected,
            belief=float(self.progress.belief.probabilities[0, label]),
            looks=self.progress.visible[0].looks,
            forced=forced,
        )

    def skip(self, *, decided: bool) -> None:
        """Pass over an empty place: nothing to sort."""
        self.record("skip", viewpoints=self.progress.visible[0].empty, decided=decided)


def _state_after(failure: BaseException) -> State:
    """Return the state in which a run ends early: held if it can go on once the cell has been seen to."""
    match failure:
        case EmergencyStopError():
            return State.ABORTED
        case CellError():
            return State.HELD
        case KeyboardInterrupt():
            return State.STOPPED
        case _:
            return State.ABORTED


def _settings(policy: Policy) -> dict[str, Any] | None:
    return policy.settings if isinstance(policy, Despot) else None


def _plain(action: Move | Decide) -> dict[str, int]:
    """Return an action as the journal keeps it."""
    match action:
        case Move(viewpoint):
            return {"move": viewpoint}
        case Decide(label):
            return {"decide": label}


def _check_fit(cell: Cell, model: SortingModel) -> None:
    classes = list(model.classes)
    if classes[-1] == model.empty and model.empty not in cell.classes:
        classes.pop()
    pairs: list[tuple[str, Any, Any]] = [
        ("classes", list(cell.classes), classes),
        ("viewpoints", list(cell.viewpoints), list(model.viewpoints)),
        ("positions", cell.layout.positions, model.positions),
    ]
    for name, of_cell, of_model in pairs:
        if of_cell != of_model:
            raise CellError(
                f"the cell's {name} are {of_cell}, the model's {of_model}; they must agree, in order: "
                "estimate the tables with this cell"
            )
