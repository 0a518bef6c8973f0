"""The loop: scan -> perceive -> belief -> plan -> act -> journal."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

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


class PerceivedPosition(Protocol):
    """What the loop needs to know of one belt position after a scan."""

    @property
    def label(self) -> int | None:
        """Class index, or None if what was seen got no label."""

    @property
    def empty(self) -> bool:
        """Whether nothing was seen there."""


Perceive = Callable[[Scan], Sequence[PerceivedPosition]]


@dataclass(frozen=True)
class Rules:
    """What keeps the loop from hanging.

    Attributes
    ----------
    max_looks
        An object scanned this often is decided as its most likely class, or goes to the cell's `reject_bin`.
        With poor tables and a large penalty, looking for ever would be optimal.
    empty_looks
        A position seen empty in so many scans in a row, each from another viewpoint as far as there are, is
        empty.
    impossible_labels
        So many labels in a row that the belief holds impossible are treated like `max_looks`.
    scan_attempts
        Unusable scans in a row after which the camera is taken to be broken.
    """

    max_looks: int = 60
    empty_looks: int = 2
    impossible_labels: int = 3
    scan_attempts: int = 3


@dataclass
class _Seen:
    """What is known of one object besides the belief."""

    looks: int = 0
    empty: list[int] = field(default_factory=list)
    impossible: int = 0


def sort_objects(
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    model: SortingModel,
    journal: Journal,
    *,
    objects: int,
    rules: Rules | None = None,
) -> SortingReport:
    """Sort the next objects of the belt, journalling every step.

    Parameters
    ----------
    cell
        Arm, camera, belt and bins; its classes, viewpoints and positions must be the model's.
    perceive
        From a scan to one result per position, the belt end first.
    policy
        Names the next action.
    model
        Updates the belief.
    journal
        An open journal. Its last entry is `end`, also after an error or an interrupt.
    objects
        Belt places to work through, object 0 standing at the belt end now. An empty one is skipped.
    rules
        Limits; default `Rules()`.

    Raises
    ------
    CellError
        If cell and model do not fit, or the camera gives no usable scan.
    BeltsortError
        Whatever else the cell, perception or the policy raise.
    """
    _check_fit(cell, model)
    loop = _Loop(cell, perceive, policy, model, journal, rules or Rules())
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
    ) -> None:
        self.cell, self.perceive, self.policy = cell, perceive, policy
        self.model, self.journal, self.rules = model, journal, rules
        self.belief = Belief(model)
        self.viewpoint = self.index = self.steps = 0
        self.visible = [_Seen() for _ in range(model.positions)]
        self.decisions: list[Decision] = []
        self.skipped: list[int] = []

    def start(self, objects: int) -> None:
        """Bring the arm to where the planner takes it to be."""
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
        """Whether the belt end was seen empty often enough, and from enough viewpoints where there are."""
        seen = self.visible[0].empty
        untried = set(self.model.travel[self.viewpoint]) - set(seen)
        enough = self.rules.empty_looks
        return len(seen) >= enough and (len(set(seen)) >= enough or not untried)

    def confirmation(self) -> Move | None:
        """Return the move that would confirm an empty belt end, to a viewpoint not tried yet if possible."""
        tried = self.visible[0].empty
        legal = self.model.travel[self.viewpoint]
        if not tried or not legal:
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
        """Move, scan, perceive, and update the belief."""
        with self.journal.command("move", viewpoint=viewpoint) as command_id:
            arrival = self.cell.move_to(viewpoint, command_id)
        self.viewpoint = viewpoint
        self.steps += 1
        perceived = self.scan(arrival)
        probabilities = self.belief.label_probabilities(viewpoint)
        dropped = []
        for position, (seen, what) in enumerate(zip(self.visible, perceived, strict=True)):
            seen.looks += 1
            seen.empty = [*seen.empty, viewpoint] if what.empty else []
            if what.label is not None and not self.take_in(position, what.label):
                probability = float(probabilities[position, what.label])
                dropped.append({"position": position, "label": what.label, "probability": probability})
        self.journal.append(
            "scan",
            viewpoint=viewpoint,
            labels=[what.label for what in perceived],
            empty=[what.empty for what in perceived],
            dropped=dropped,
            belief=self.belief.probabilities.tolist(),
        )

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
        """Sort the object at the belt end and bring the next one there."""
        rejected = forced is not None and self.cell.reject_bin is not None
        bin_label = self.cell.reject_bin if rejected and self.cell.reject_bin is not None else label
        with self.journal.command("sort", label=bin_label) as command_id:
            self.cell.sort(bin_label, command_id)
        self.steps += 1
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
        """Bring the next object to the belt end."""
        with self.journal.command("advance", index=self.index + 1) as command_id:
            self.cell.advance_to(self.index + 1, command_id)
        self.index += 1
        self.journal.object = self.index
        self.belief.advance()
        self.visible = [*self.visible[1:], _Seen()]


def _plain(action: Move | Decide) -> dict[str, int]:
    """Return an action as the journal keeps it."""
    match action:
        case Move(viewpoint):
            return {"move": viewpoint}
        case Decide(label):
            return {"decide": label}


def _check_fit(cell: Cell, model: SortingModel) -> None:
    pairs: list[tuple[str, Any, Any]] = [
        ("classes", list(cell.classes), list(model.classes)),
        ("viewpoints", list(cell.viewpoints), list(model.viewpoints)),
        ("positions", cell.layout.positions, model.positions),
    ]
    for name, of_cell, of_model in pairs:
        if of_cell != of_model:
            raise CellError(
                f"the cell's {name} are {of_cell}, the model's {of_model}; they must agree, in order: "
                "estimate the tables with this cell"
            )
