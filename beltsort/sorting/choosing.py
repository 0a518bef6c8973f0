"""Choice of the next action, by the loop's rules or else by the policy."""

from beltsort._core import Decide, Despot, Move, PolicyError
from beltsort.cell import Cell
from beltsort.cell.bins import bin_of
from beltsort.cell.commands import MoveTo
from beltsort.cell.protocols import KnowsClasses
from beltsort.planning.decisions import best_bin, probability_right
from beltsort.planning.policy import Policy
from beltsort.sorting.commander import Commander
from beltsort.sorting.entries import Chosen, Decided, Planned, Skipped
from beltsort.sorting.record import Record
from beltsort.sorting.rules import Rules

LATE = 1.2
"""The journal marks a plan as late if it took more than this multiple of its time budget."""


class Chooser:
    """Chooses the next action, journals it, and issues the command of a move.

    Parameters
    ----------
    cell
        The cell; undecided objects go to its reject bin, if it has one.
    policy
        Chooses the action unless a rule does.
    record
        Writes an entry and applies it to the run's progress.
    rules
        Limits.
    commander
        Sends the commands of moves.
    """

    def __init__(
        self, cell: Cell, policy: Policy, record: Record, rules: Rules, commander: Commander
    ) -> None:
        self._cell, self._policy, self._record, self._rules = cell, policy, record, rules
        self._commander = commander
        self._progress, self._model = record.progress, record.progress.model

    def choose(self) -> None:
        """Skip an empty cup, apply the rule that ends the looks at an object, or follow the policy.

        Raises
        ------
        PolicyError
            If the model does not allow the action that the policy returns.
        BeltsortError
            As `Commander.issue`, and any error of the policy.
        """
        belt_end = self._progress.visible[0]
        legal = self._model.travel[self._progress.viewpoint]
        no_class_for_empty = self._model.empty is None
        if no_class_for_empty and belt_end.known_empty(self._rules, legal):
            self._record(Skipped(belt_end.empty, decided=False))
        elif no_class_for_empty and belt_end.empty and legal:
            # Untried viewpoints first.
            move = Move(min(legal, key=lambda viewpoint: (viewpoint in belt_end.empty, viewpoint)))
            self._record(Chosen(_plain(move), why="the belt end was seen empty: look again"))
            self._commander.issue(MoveTo(move.viewpoint))
        elif belt_end.looks >= self._rules.max_looks:
            self._decide(best_bin(self._progress.belief), forced="max_looks")
        elif belt_end.impossible >= self._rules.impossible_labels:
            self._decide(best_bin(self._progress.belief), forced="impossible_labels")
        else:
            match self._plan():
                case Move(viewpoint):
                    self._commander.issue(MoveTo(viewpoint))
                case Decide(bin):
                    self._decide(bin)

    def _plan(self) -> Move | Decide:
        """Return the policy's action, after journalling it."""
        belief, viewpoint = self._progress.belief, self._progress.viewpoint
        if not isinstance(self._policy, Despot):
            action = self._policy.act(belief.copy(), viewpoint)
            self._check_legal(action)
            self._record(Chosen(_plain(action)))
            return action
        plan = self._policy.plan(belief, viewpoint)
        self._record(
            Planned(
                _plain(plan.action),
                values=[{**_plain(action), "value": value} for action, value in plan.values.items()],
                lower=plan.lower,
                upper=plan.upper,
                trials=plan.trials,
                seconds=plan.seconds,
                late=plan.seconds > LATE * (self._policy.settings["seconds"] or float("inf")),
            )
        )
        return plan.action

    def _check_legal(self, action: object) -> None:
        """Raise a `PolicyError` if the model does not allow an action."""
        moves = [Move(viewpoint) for viewpoint in self._model.travel[self._progress.viewpoint]]
        legal = [*moves, *(Decide(bin) for bin in range(len(self._model.bins)))]
        if action not in legal:
            raise PolicyError(
                f"the policy returned {action!r} at viewpoint {self._progress.viewpoint}; legal are {legal}"
            )

    def _decide(self, bin: int, forced: str | None = None) -> None:
        """Journal the decision about the object at the belt end, or that its cup is skipped as empty."""
        belt_end, rejected = self._progress.visible[0], self._cell.reject_bin if forced is not None else None
        if self._model.bins[bin] == self._model.empty and rejected is None:
            self._record(Skipped(belt_end.empty, decided=True))
            return
        into, index = bin if rejected is None else rejected, self._progress.index
        self._record(
            Decided(
                label=bin if rejected is None else None,
                bin=into,
                belief=probability_right(self._progress.belief, bin),
                looks=belt_end.looks,
                forced=forced,
                name=bin_of(self._cell, into).name,
                true_class=self._cell.true_class(index) if isinstance(self._cell, KnowsClasses) else None,
            )
        )


def _plain(action: Move | Decide) -> dict[str, int]:
    """Return an action as plain data for the journal."""
    match action:
        case Move(viewpoint):
            return {"move": viewpoint}
        case Decide(bin):
            return {"decide": bin}
