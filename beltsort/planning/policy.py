"""The protocol of policies."""

from typing import Protocol

from beltsort._core import Belief, Decide, Move


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
