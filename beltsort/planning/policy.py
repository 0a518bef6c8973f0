"""What a policy is."""

from typing import Protocol

from beltsort._core import Belief, Decide, Move


class Policy(Protocol):
    """Anything that names the next action: `Despot`, the simple policies, or your own object.

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
        """Name the next action.

        Parameters
        ----------
        belief
            What is known of the objects; the policy may change it, it is a copy.
        viewpoint
            Where the camera stands.

        Returns
        -------
        Move or Decide
            An action that the model allows from there.
        """
        ...
