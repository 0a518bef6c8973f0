"""How long a planner for a moving belt takes."""

from beltsort._core import DecideAt, Move, MovingBelief, MovingPlanner, Wait


class TimedPlanner:
    """A planner as a policy that notes how long its plans take.

    Attributes
    ----------
    planner
        The planner.
    seconds
        Wall-clock time of each plan so far.
    """

    def __init__(self, planner: MovingPlanner) -> None:
        self.planner = planner
        self.seconds: list[float] = []

    def act(self, belief: MovingBelief, viewpoint: int) -> Move | Wait | DecideAt:
        """Return the planner's action."""
        plan = self.planner.plan(belief, viewpoint)
        self.seconds.append(plan.seconds)
        return plan.action
