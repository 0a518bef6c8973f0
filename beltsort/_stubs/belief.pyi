from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort._stubs.model import SortingModel

@final
class Belief:
    """The factored belief: one distribution over the N kinds (class and mode) per belt position.

    Objects are independent and each label depends on its own object only, so the product of these
    distributions is the exact posterior. Where the model's `repeat` is above 0, the last label of each
    position from each viewpoint belongs to the belief. It changes in place; `copy` it to keep one.

    Parameters
    ----------
    model : SortingModel
        Gives the shape, the observation tables and the arrival prior.
    probabilities : array_like, shape (H, L) or (H, N), optional
        One distribution over the classes, or the kinds, per position, the belt end first. Rows may miss 1 by
        1e-6 and are normalised; those that miss it by rounding only are kept to the last bit. The arrival
        prior at every position if missing. A probability of 0 is for ever: no label can raise it.
    last_labels : array_like of int, shape (H, K), optional
        Last labels since the belt moved, -1 for none, which is what is taken if missing. With both arguments
        a belief is rebuilt from its record. Labels that the model cannot repeat are forgotten.
    remaining : int, optional
        Objects left to decide, the one at the belt end included; missing for a belt that never ends. Planners
        that take it into account (`Despot`, `LookAhead`, `OneObject`) look longer at the last objects, which
        delay no others.

    Raises
    ------
    ArgumentError
        If `probabilities` or `last_labels` has another shape, a row is no distribution, the model has no
        such label, or `remaining` is below 0.

    References
    ----------
    Mezei, Tamás & Buşoniu, ECC 2019, eq. 7 (`observe`) and eq. 8 (`advance`).

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belief = beltsort.Belief(model)
    >>> belief.observe("front", ["bolt"])
    >>> belief
    Belief
      position    nut   bolt
      1         0.200  0.800
    >>> belief.most_likely(0)
    (1, 0.8)
    """

    def __new__(
        cls,
        model: SortingModel,
        probabilities: ArrayLike | None = None,
        last_labels: ArrayLike | None = None,
        remaining: int | None = None,
    ) -> Belief: ...
    @property
    def model(self) -> SortingModel:
        """The model that this belief was made for."""
    @property
    def probabilities(self) -> NDArray[np.float64]:
        """`b^j_i`: probability that the object at position j is of class i, float64 (H, L); a copy."""
    @property
    def kinds(self) -> NDArray[np.float64]:
        """Probability that the object at position j is of kind n, float64 of shape (H, N); a copy.

        The kinds are the modes of the first class, then those of the second, and so on; without `modes` they
        are the classes.
        """
    @property
    def last_labels(self) -> NDArray[np.int64]:
        """Last label of each position from each viewpoint since the belt moved, int64 (H, K); a copy.

        -1 where there is none, or where the model's `repeat` is 0.
        """
    @property
    def remaining(self) -> int | None:
        """Objects left to decide, the one at the belt end included; None for a belt that never ends."""
    def label_probabilities(self, viewpoint: int | str) -> NDArray[np.float64]:
        """Return the probability of each label at each position if the camera scanned from a viewpoint.

        Parameters
        ----------
        viewpoint : int or str
            Index or name of the viewpoint.

        Returns
        -------
        numpy.ndarray
            float64 of shape (H, Z): `sum_n b[j, n] P(z | j, viewpoint, n)` for position j and label z, where
            b are the `kinds` and P is `p_obs`, mixed with the last label by the model's `repeat`.

        Raises
        ------
        ArgumentError
            If the model has no such viewpoint.
        """
    def observe(self, viewpoint: int | str, labels: Sequence[int | str | None]) -> None:
        """Update the belief by the labels of one scan, with Bayes' rule.

        `b[j, n]` becomes proportional to `b[j, n] P(labels[j] | j, viewpoint, n)`, where b are the `kinds`
        and P is `p_obs`, mixed with the last label by the model's `repeat`.

        Parameters
        ----------
        viewpoint : int or str
            Index or name of the viewpoint that the scan was taken from.
        labels : sequence of int, str or None, length H
            The label of each position, index or name, the belt end first: the class that it was taken for,
            unless the model has `labels`; None where nothing was seen.

        Raises
        ------
        ArgumentError
            For another number of labels, or a label or viewpoint that the model has not.
        ImpossibleObservationError
            For a label of probability 0. The belief is then unchanged.

        References
        ----------
        Mezei, Tamás & Buşoniu, ECC 2019, eq. 7.
        """
    def advance(self) -> None:
        """Advance the belt by one position.

        Each position takes over the distribution behind it, the last one the arrival prior. Last labels are
        forgotten, and one object less is left.

        References
        ----------
        Mezei, Tamás & Buşoniu, ECC 2019, eq. 8.
        """
    def most_likely(self, position: int) -> tuple[int, float]:
        """Return the most likely class at a position (the lowest label among equals) and its probability.

        Parameters
        ----------
        position : int
            Index of a belt position, 0 at the belt end.

        Returns
        -------
        label : int
            Index of the class.
        probability : float
            Its probability.

        Raises
        ------
        ArgumentError
            If the model has no such position.
        """
    def copy(self) -> Belief:
        """Return an independent belief, equal to this one."""
    def __eq__(self, value: object, /) -> bool: ...
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> Belief: ...
    def __deepcopy__(self, _memo: object) -> Belief: ...
