"""The protocols of policies."""

from typing import Protocol

from beltsort._core import Belief, Decide, DecideAt, Move, MovingBelief, Wait


class Policy(Protocol):
    """Chooses the next action: `Despot`, the simple policies, or an object of your own.

    Examples
    --------
    >>> import beltsort
    >>> class DecideUnseen:
    ...     def act(self, belief: beltsort.Belief, viewpoint: int) -> beltsort.Decide:
    ...         label, _ = belief.most_likely(0)
    ...         return beltsort.Decide(label)
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> beltsort.evaluate(model, DecideUnseen(), batches=2).steps
    array([10, 10], dtype=uint64)
    """

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        """Return the next action.

        Parameters
        ----------
        belief
            The belief about the objects. It is a copy, which the policy may modify.
        viewpoint
            The camera's viewpoint.

        Returns
        -------
        Move or Decide
            An action that the model allows from this viewpoint.
        """
        ...


class MovingPolicy(Protocol):
    """Chooses the next action on a moving belt: `MovingPlanner`, `MovingThreshold`, or your own object.

    Examples
    --------
    >>> import beltsort
    >>> class DecideUnseen:
    ...     def act(self, belief: beltsort.MovingBelief, viewpoint: int) -> beltsort.DecideAt | beltsort.Wait:
    ...         return beltsort.Wait() if belief.decided[0] else beltsort.DecideAt(0, 0)
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
    >>> beltsort.evaluate_moving(belt, DecideUnseen(), objects=5, runs=2).ticks
    array([16, 16], dtype=uint64)
    """

    def act(self, belief: MovingBelief, viewpoint: int) -> Move | Wait | DecideAt:
        """Return the next action.

        Parameters
        ----------
        belief
            What is known of the objects, and the belt's clock. It is a copy, which the policy may modify.
        viewpoint
            The camera's viewpoint.

        Returns
        -------
        Move, Wait or DecideAt
            An action that the belt allows.
        """
        ...
