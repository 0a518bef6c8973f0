from collections.abc import Sequence
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort._stubs.moving_belt import MovingBelt

@final
class MovingBelief:
    """What is known of the objects on a moving belt, and its clock.

    Each label depends on its own object only, and everything but the kinds (class and mode) is known, so the
    product of the rows is the exact posterior. It changes in place; `copy` it to keep one.

    Parameters
    ----------
    belt : MovingBelt
        Gives shape, tables, arrival prior and durations.
    kinds : array_like, shape (H, L) or (H, N), optional
        One distribution over the classes, or the kinds, per place, the one nearest to the exit first; the
        arrival prior at every place if missing.
    decided : sequence of H bools, optional
        Whether the object at each place is decided already, or there is none; none is if missing.
    offset : int, default 0
        Ticks since the belt last advanced, below `ticks_per_place`.
    to_come : int, optional
        Objects that have not come to a place yet; if missing, the belt never ends.

    Raises
    ------
    ArgumentError
        For another shape, a row that is no distribution, or numbers out of range.

    References
    ----------
    Mezei, Tamás & Buşoniu, ECC 2019, eq. 7 (`observe`) and eq. 8 (`advance_time`).

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
    >>> belief = belt.belief(objects=3)
    >>> belief.advance_time(1)
    0.0
    >>> belief.observe("front", ["bolt"])
    >>> belief
    MovingBelief([[0.200, 0.800]], decided=[False], offset=1, to_come=2)
    """

    def __new__(
        cls,
        belt: MovingBelt,
        *,
        kinds: ArrayLike | None = None,
        decided: Sequence[bool] | None = None,
        offset: int = 0,
        to_come: int | None = None,
    ) -> MovingBelief: ...
    @property
    def belt(self) -> MovingBelt:
        """The belt that this belief was made for."""
    @property
    def probabilities(self) -> NDArray[np.float64]:
        """Probability that the object at place j is of class i, float64 of shape (H, L); a copy."""
    @property
    def kinds(self) -> NDArray[np.float64]:
        """Probability that the object at place j is of kind n, float64 of shape (H, N); a copy."""
    @property
    def decided(self) -> list[bool]:
        """Whether the object at each place is decided, or there is none; list of length H."""
    @property
    def offset(self) -> int:
        """Ticks since the belt last advanced; since the last decision if it advances on decisions."""
    @property
    def to_come(self) -> int | None:
        """Objects that have not come to a place yet; None for a belt that never ends."""
    @property
    def is_over(self) -> bool:
        """Whether nothing is left to decide, now or later."""
    def ticks_left(self, position: int) -> int | None:
        """Return the ticks until the object at a place passes the exit.

        Parameters
        ----------
        position : int
            Index of the place, 0 nearest to the exit.

        Returns
        -------
        int or None
            At least 1; None if the belt advances on decisions.

        Raises
        ------
        ArgumentError
            If there is no such place.
        """
    def most_likely(self, position: int) -> tuple[int, float]:
        """Return the most likely class at a place (the lowest label among equals) and its probability.

        Parameters
        ----------
        position : int
            Index of the place, 0 nearest to the exit.

        Returns
        -------
        label : int
            Index of the class.
        probability : float
            Its probability.

        Raises
        ------
        ArgumentError
            If there is no such place.
        """
    def best_decision(self, position: int) -> tuple[int, float]:
        """Return the bin where the object at a place is worth most, and the expected reward.

        Parameters
        ----------
        position : int
            Index of the place, 0 nearest to the exit.

        Returns
        -------
        label : int
            Index of the bin.
        reward : float
            Expected reward of putting the object there.

        Raises
        ------
        ArgumentError
            If there is no such place.
        """
    def observe(self, viewpoint: int | str, labels: Sequence[int | str | None]) -> None:
        """Update the belief by the labels of one scan, with Bayes' rule.

        Parameters
        ----------
        viewpoint : int or str
            Index or name of the viewpoint that the scan was taken from.
        labels : sequence of int, str or None, length H
            The label of each place, index or name, the one nearest to the exit first; None where nothing was
            seen. Labels of decided objects are ignored.

        Raises
        ------
        ArgumentError
            For another number of labels, or a label or viewpoint that the model has not.
        ImpossibleObservationError
            For a label of probability 0. The belief is then unchanged.
        """
    def decide(self, position: int) -> None:
        """Mark the object at a place as decided.

        It stays where it is, unless the belt advances on decisions: then all that is known moves on by one
        place. Let the belt's `decision_ticks` pass afterwards.

        Parameters
        ----------
        position : int
            Index of the place, 0 nearest to the exit.

        Raises
        ------
        ArgumentError
            If it is out of reach, or decided already. The belief is then unchanged.
        """
    def advance_time(self, ticks: int) -> float:
        """Let time pass.

        At each advance of the belt every place takes over what is known of the one behind it, and the last
        one the arrival prior.

        Parameters
        ----------
        ticks : int
            How many ticks pass.

        Returns
        -------
        float
            Expected price of the objects that passed the exit undecided, discounted to the beginning.

        Raises
        ------
        ArgumentError
            For a negative number, or more than 4,294,967,295.
        """
    def copy(self) -> MovingBelief:
        """Return an independent belief, equal to this one."""
    def __eq__(self, other: object) -> bool: ...
    def __ne__(self, other: object) -> bool: ...
    def __copy__(self) -> MovingBelief: ...
    def __deepcopy__(self, _memo: Any) -> MovingBelief: ...
    def __reduce__(self) -> tuple[Any, Any]: ...
    __hash__: None  # type: ignore[assignment] # equality without a hash, as NumPy arrays
