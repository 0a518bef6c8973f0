"""Choice of the next action on a belt that never stops."""

from beltsort._core import DecideAt, Move, MovingBelief, MovingPlanner, PolicyError, Wait
from beltsort.planning.policy import MovingPolicy
from beltsort.sorting.choosing import LATE
from beltsort.sorting.entries import Chosen, Planned
from beltsort.sorting.moving.record import MovingRecord


class MovingChooser:
    """Asks the policy, and journals its action.

    Parameters
    ----------
    policy
        Chooses the actions.
    record
        Writes entries and applies them to the run's state.
    tick
        Seconds of a tick: a plan that takes longer is marked as late.
    """

    def __init__(self, policy: MovingPolicy, record: MovingRecord, tick: float) -> None:
        self._policy, self._record, self._tick = policy, record, tick

    def choose(self, belief: MovingBelief) -> Move | Wait | DecideAt:
        """Return the policy's action, after journalling it.

        Raises
        ------
        PolicyError
            If the action is not legal.
        """
        viewpoint, belt = self._record.state.viewpoint, self._record.state.belt
        if isinstance(self._policy, MovingPlanner):
            plan = self._policy.plan(belief, viewpoint)
            self._record(
                Planned(
                    _plain(plan.action),
                    values=[{**_plain(action), "value": value} for action, value in plan.values.items()],
                    lower=plan.lower,
                    upper=plan.upper,
                    trials=plan.trials,
                    seconds=plan.seconds,
                    late=plan.seconds > LATE * self._tick,
                )
            )
            return plan.action
        action = self._policy.act(belief, viewpoint)
        model = belt.model
        legal = isinstance(action, Wait)
        if isinstance(action, Move):
            legal = action.viewpoint in model.travel[viewpoint]
        elif isinstance(action, DecideAt):
            within = 0 <= action.position < belt.reach and not belief.decided[action.position]
            legal = within and 0 <= action.label < len(model.bins)
        if not legal:
            raise PolicyError(
                f"the policy returned {action!r} at viewpoint {viewpoint}; legal are moves to "
                f"{list(model.travel[viewpoint])}, Wait(), and DecideAt for an undecided object at one of "
                f"the first {belt.reach} places"
            )
        self._record(Chosen(_plain(action)))
        return action


def _plain(action: Move | Wait | DecideAt) -> dict[str, int]:
    """Return an action as plain data for the journal."""
    match action:
        case Move(viewpoint):
            return {"move": viewpoint}
        case DecideAt(position, bin):
            return {"decide": bin, "position": position}
        case Wait():
            return {"wait": 1}
