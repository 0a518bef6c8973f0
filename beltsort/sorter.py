"""The loop: scan -> perceive -> belief -> plan -> act -> journal."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import beltsort
from beltsort._core import (
    Belief,
    Decide,
    Despot,
    ImpossibleObservationError,
    Move,
    PolicyError,
    SortingModel,
)
from beltsort.cell.protocols import Cell, Scan
from beltsort.errors import CellError, CloudError
from beltsort.journal import Journal
from beltsort.policy import Policy
from beltsort.report import Decision, SortingReport
from beltsort.rules import Rules, Seen

if TYPE_CHECKING:
    from beltsort.tables import DriftWatch


class PerceivedPosition(Protocol):
    """What the loop needs to know of one belt position after a scan."""

    @property
    def label(self) -> int | None:
        """Class index, or None if what was seen got no label."""

    @property
    def empty(self) -> bool:
        """Whether nothing was seen there."""


Perceive = Callable[[Scan], Sequence[PerceivedPosition]]


def sort_objects(
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    model: SortingModel,
    journal: Journal,
    *,
    objects: int,
    rules: Rules | None = None,
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
        An open journal. Its last entry is `end`, also after an error or an interrupt.
    objects
        Belt places to work through, object 0 standing at the belt end now. An empty one is skipped: when
        `Rules.empty_looks` says so or, if the model has a class for empty cups, when that is decided.
    rules
        Limits; default `Rules()`.
    watch
        Sees every scan; its alarms are journalled as `drift`, and the run goes on.

    Raises
    ------
    CellError
        If cell and model do not fit, or the camera gives no usable scan.
    BeltsortError
        Whatever else the cell, perception or the policy raise.
    """
    _check_fit(cell, model)
    loop = _Loop(cell, perceive, policy, model, journal, rules or Rules(), watch)
    try:
        loop.start(objects)
        while loop.index < objects:
            loop.step()
    except BaseException as failure:
        journal.append("end", reason=repr(failure))
        raise
    journal.append("end", reason="done")
    return SortingReport(loop.steps, tuple(loop.decisions), tuple(loop.skipped))


class _Loop:
    def __init__(
        self,
        cell: Cell,
        perceive: Perceive,
        policy: Policy,
        model: SortingModel,
        journal: Journal,
        rules: Rules,
        watch: "DriftWatch | None",
    ) -> None:
        self.cell, self.perceive, self.policy = cell, perceive, policy
        self.model, self.journal, self.rules, self.watch = model, journal, rules, watch
        self.belief = Belief(model)
        self.empty = None if model.empty is None else model.classes.index(model.empty)
        self.viewpoint = self.index = self.steps = self.objects = 0
        self.visible = [Seen() for _ in range(model.positions)]
        self.decisions: list[Decision] = []
        self.skipped: list[int] = []

    def start(self, objects: int) -> None:
        """Bring the arm to where the planner takes it to be."""
        self.objects = objects
        self.journal.append(
            "start", objects=objects, model=self.model.to_json(), beltsort=beltsort.__version__
        )
        self.journal.object = self.index
        with self.journal.command("move", viewpoint=self.viewpoint) as command_id:
            self.cell.move_to(self.viewpoint, command_id)

    def step(self) -> None:
        """Skip an empty place, decide where a rule says so, or do what the policy names."""
        belt_end = self.visible[0]
        if self.known_empty():
            self.skip()
        elif confirming := self.confirmation():
            self.look_from(confirming.viewpoint)
        elif belt_end.looks >= self.rules.max_looks:
            self.decide(self.belief.most_likely(0)[0], forced="max_looks")
        elif belt_end.impossible >= self.rules.impossible_labels:
            self.decide(self.belief.most_likely(0)[0], forced="impossible_labels")
        else:
            self.follow_policy()

    def follow_policy(self) -> None:
        """Plan, and do it."""
        match self.plan():
            case Move(viewpoint):
                self.look_from(viewpoint)
            case Decide(label):
                self.decide(label)

    def known_empty(self) -> bool:
        """Whether the rule of `empty_looks` says that the belt end is empty."""
        reachable = self.model.travel[self.viewpoint]
        return self.empty is None and self.visible[0].known_empty(self.rules, reachable)

    def confirmation(self) -> Move | None:
        """Return the move that would confirm an empty belt end, to a viewpoint not tried yet if possible."""
        tried = self.visible[0].empty
        legal = self.model.travel[self.viewpoint]
        if self.empty is not None or not tried or not legal:
            return None
        move = Move(min(legal, key=lambda viewpoint: (viewpoint in tried, viewpoint)))
        self.journal.append("plan", action=_plain(move), why="the belt end was seen empty: look again")
        return move

    def plan(self) -> Move | Decide:
        """Ask the policy."""
        if not isinstance(self.policy, Despot):
            action = self.policy.act(self.belief.copy(), self.viewpoint)
            self.check_legal(action)
            self.journal.append("plan", action=_plain(action))
            return action
        plan = self.policy.plan(self.belief, self.viewpoint)
        self.journal.append(
            "plan",
            action=_plain(plan.action),
            values=[{**_plain(action), "value": value} for action, value in plan.values.items()],
            lower=plan.lower,
            upper=plan.upper,
            trials=plan.trials,
        )
        return plan.action

    def check_legal(self, action: object) -> None:
        """Refuse what the model does not allow, before anything moves."""
        moves = [Move(viewpoint) for viewpoint in self.model.travel[self.viewpoint]]
        legal = [*moves, *(Decide(label) for label in range(len(self.model.classes)))]
        if action not in legal:
            raise PolicyError(
                f"the policy returned {action!r} at viewpoint {self.viewpoint}; legal are {legal}"
            )

    def look_from(self, viewpoint: int) -> None:
        """Move and observe."""
        with self.journal.command("move", viewpoint=viewpoint) as command_id:
            arrival = self.cell.move_to(viewpoint, command_id)
        self.viewpoint = viewpoint
        self.steps += 1
        self.observe(arrival)

    def observe(self, stopped: float) -> None:
        """Scan from where the camera stands, perceive, and update the belief."""
        perceived = self.scan(stopped)
        labels = [self.label_of(what) for what in perceived]
        probabilities = self.belief.label_probabilities(self.viewpoint)
        alarms = self.watch.observe(self.belief, self.viewpoint, labels) if self.watch else []
        dropped = []
        for position, (seen, label) in enumerate(zip(self.visible, labels, strict=True)):
            seen.looks += 1
            seen.empty = [*seen.empty, self.viewpoint] if perceived[position].empty else []
            if label is not None and not self.take_in(position, label):
                probability = float(probabilities[position, label])
                dropped.append({"position": position, "label": label, "probability": probability})
        self.journal.append(
            "scan",
            viewpoint=self.viewpoint,
            labels=labels,
            empty=[what.empty for what in perceived],
            dropped=dropped,
            belief=self.belief.probabilities.tolist(),
            last_labels=self.belief.last_labels.tolist(),
        )
        for alarm in alarms:
            self.journal.append("drift", **alarm.to_dict())

    def label_of(self, what: PerceivedPosition) -> int | None:
        """Return the label of one position; the model may have a class for empty cups."""
        return self.empty if what.empty and self.empty is not None else what.label

    def take_in(self, position: int, label: int) -> bool:
        """Update the belief about one position; return False, and only count, if the label is impossible."""
        labels = [label if j == position else None for j in range(self.model.positions)]
        try:
            self.belief.observe(self.viewpoint, labels)
        except ImpossibleObservationError:
            self.visible[position].impossible += 1
            return False
        self.visible[position].impossible = 0
        return True

    def scan(self, arrival: float) -> Sequence[PerceivedPosition]:
        """Take a scan that perception can use."""
        for _ in range(self.rules.scan_attempts):
            scan = self.cell.scan(not_before=arrival)
            try:
                return self.perceive(scan)
            except CloudError as reason:
                self.journal.append("bad_scan", stamp=scan.stamp, error=str(reason))
        raise CellError(
            f"{self.rules.scan_attempts} scans in a row are unusable, expected a point cloud; check the "
            f"camera ({self.journal.path} tells what each lacked)"
        )

    def decide(self, label: int, forced: str | None = None) -> None:
        """Sort the object at the belt end, or pass over an empty cup, and bring the next one there."""
        self.steps += 1
        rejected = forced is not None and self.cell.reject_bin is not None
        if label == self.empty and not rejected:
            self.skip()
            return
        bin_label = self.cell.reject_bin if rejected and self.cell.reject_bin is not None else label
        with self.journal.command("sort", label=bin_label) as command_id:
            self.cell.sort(bin_label, command_id)
        probability = float(self.belief.probabilities[0, label])
        decided = None if rejected else label
        decision = Decision(self.index, decided, probability, self.visible[0].looks, forced)
        self.decisions.append(decision)
        self.journal.append(
            "decision", label=decided, belief=probability, looks=decision.looks, forced=forced
        )
        self.advance()

    def skip(self) -> None:
        """Pass over an empty place: nothing to sort, no decision."""
        self.skipped.append(self.index)
        self.journal.append("skip", viewpoints=self.visible[0].empty)
        self.advance()

    def advance(self) -> None:
        """Bring the next object to the belt end, and observe if the model says so."""
        with self.journal.command("advance", index=self.index + 1) as command_id:
            stopped = self.cell.advance_to(self.index + 1, command_id)
        self.index += 1
        self.journal.object = self.index
        self.belief.advance()
        self.visible = [*self.visible[1:], Seen()]
        if self.model.observe_after_decision and self.index < self.objects:
            self.observe(stopped)


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
