"""A belt that stands while the camera looks, as a yardstick for one that never stops."""

from beltsort._core import Belief, Decide, DecideAt, Move, MovingBelief, MovingBelt
from beltsort.planning.policy import Policy


def stop_and_go_belt(belt: MovingBelt) -> MovingBelt:
    """Return the same arm and sorter at a belt that stands while the arm looks.

    It advances by one place after each decision on the object at the exit. An advance takes as long as the
    moving belt takes for a place; looks take as long as on the moving belt.

    Parameters
    ----------
    belt
        A belt of constant speed.

    Raises
    ------
    ArgumentError
        If the belt advances on decisions already.
    """
    settings = {**belt.settings, "ticks_per_place": None, "reach": 1, "sort_ticks": 0}
    return MovingBelt(belt.model, **{**settings, "advance_ticks": belt.ticks_per_place})


class StopAndGo:
    """A policy for the model alone, on a belt that advances on decisions.

    Parameters
    ----------
    policy
        Decides on the object at the exit, and chooses looks until then.

    Examples
    --------
    >>> import beltsort
    >>> belt = stop_and_go_belt(beltsort.MovingBelt(beltsort.models.paper(), ticks_per_place=4))
    >>> StopAndGo(beltsort.Threshold(belt.model, 0.9)).act(belt.belief(), 0)
    Move(viewpoint=2)
    """

    def __init__(self, policy: Policy) -> None:
        self.policy = policy

    def act(self, belief: MovingBelief, viewpoint: int) -> Move | DecideAt:
        """Return the policy's action, a decision as one on the object at the exit."""
        action = self.policy.act(Belief(belief.belt.model, belief.kinds), viewpoint)
        return DecideAt(0, action.label) if isinstance(action, Decide) else action
