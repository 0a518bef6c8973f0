from collections.abc import Sequence
from os import PathLike
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Path: TypeAlias = str | PathLike[str]

@final
class SortingModel:
    """The sorting POMDP: sets, observation tables, rewards and travel. It does not change once made.

    L classes, K viewpoints, and H belt positions that one scan sees at once, index 0 at the belt end. The
    parameters are the keys of a model file.

    Parameters
    ----------
    classes : sequence of str, length L
        Names `c_1..c_L`, at least two, unique.
    viewpoints : sequence of str, length K
        Names `p_1..p_K`, unique.
    p_obs : array_like, shape (H, K, L, L), or (H, K, N, Z) with `modes` and `labels`
        `o^j(z | p', c)` as ``p_obs[j, viewpoint, true, observed]``. Rows may miss 1 by 1e-6: they are kept as
        given and normalised in the arithmetic. A 0 makes a belief irrevocable.
    labels : sequence of str, length Z, optional
        What one look may yield: classes with a confidence ("livarno, sure"), "not recognised". The classes if
        missing.
    bins : sequence of str, length B, optional
        What a decision chooses; several classes may belong into one bin, and a manual bin is a bin. The
        classes if missing.
    reward : array_like, shape (B, L), optional
        Worth of putting class c into bin b, ``reward[bin, class]``, in place of `r_max` and `r_min`. Some
        entry is above 0. If missing, `r_max` for a class's own bin and ``-r_min`` elsewhere.
    modes : sequence of sequence of float, length L, optional
        For each class the weights of its modes, which sum to 1: ways to lie or to look that change what is
        seen of an object for as long as it is on the belt. A mode is drawn when the object arrives and stays
        hidden. The N modes of all classes, ordered by class, are the *kinds*, the rows of `p_obs`. One mode
        per class if missing.
    r_max : float, default 10
        Reward of a right decision.
    r_min : float, default 50
        Penalty of a wrong decision, above 0. Too large, and looking for ever is optimal.
    motion_cost : float or array_like, shape (K, K)
        Cost of a move, or ``motion_cost[start, end]``; 1 if missing. Too large, and deciding unseen is
        optimal.
    discount : float, default 0.95
        `gamma`, per planner step, strictly between 0 and 1. Nearer to 1 means searching deeper for the same
        error.
    arrival : sequence of float, length L
        Prior of the class of an arriving object; uniform if missing.
    travel : sequence of sequence of int, length K
        ``travel[k]`` lists the viewpoints that one move from k reaches, k itself included if it may scan
        again from there; all if missing. An empty list leaves only decisions.
    observe_after_decision : bool
        Whether a scan of all positions, from where the camera stands, follows each decision within the same
        step; in the paper nothing is observed then.
    repeat : float or array_like, shape (H, K)
        Probability, at least 0 and below 1, that a second look from the same viewpoint at the same object in
        the same position only repeats the last label: ``P(z' | z, v, c) = repeat [z' = z] + (1 - repeat)
        p_obs[j, v, c, z']``. 0 if missing: labels are independent given the class. Too small, and repeated
        looks make the belief overconfident.
    information_gain : float
        `alpha`, reward per nat of entropy that a scan is expected to take from the belief, summed over the
        positions. 0 for the paper's rewards. Too large, and looking on is worth more than deciding.
    empty : str, optional
        The one of `classes` that stands for an empty cup: deciding it passes over the place.
    label_rule : dict, optional
        How perception makes a label of what a classifier returns, kept for it beside the tables that were
        counted with it; planning does not use it.
    counts : array_like of int, shape (H, K, N, Z)
        The label counts behind `p_obs`, for the record.
    smoothing : float or array_like of float, shape (H, K, N, Z)
        The pseudo-counts that were added to the entries of `counts`, for the record.
    note : str
        Free text.

    Raises
    ------
    ModelError
        Naming the first value that does not fit, what was expected, and the remedy.

    References
    ----------
    Mezei, Tamás & Buşoniu, "Sorting objects from a conveyor belt using active perception with a POMDP model",
    ECC 2019, eq. 1-6.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]], r_min=20)
    >>> model.p_obs.shape
    (1, 1, 2, 2)
    >>> beltsort.SortingModel.from_json(model.to_json()) == model
    True
    """

    def __new__(
        cls,
        classes: Sequence[str],
        viewpoints: Sequence[str],
        p_obs: ArrayLike,
        *,
        labels: Sequence[str] | None = None,
        bins: Sequence[str] | None = None,
        reward: ArrayLike | None = None,
        modes: Sequence[Sequence[float]] | None = None,
        r_max: float | None = None,
        r_min: float | None = None,
        motion_cost: ArrayLike | None = None,
        discount: float = ...,
        arrival: Sequence[float] | None = None,
        travel: Sequence[Sequence[int]] | None = None,
        observe_after_decision: bool = False,
        repeat: ArrayLike | None = None,
        information_gain: float = 0.0,
        empty: str | None = None,
        label_rule: dict[str, Any] | None = None,
        counts: ArrayLike | None = None,
        smoothing: ArrayLike | None = None,
        note: str = "",
    ) -> SortingModel: ...
    @staticmethod
    def load(path: _Path) -> SortingModel:
        """Read a model file.

        Parameters
        ----------
        path : str or os.PathLike
            A JSON file with the constructor's parameters as keys.

        Returns
        -------
        SortingModel
            The model.

        Raises
        ------
        ModelError
            If the file cannot be read, is not JSON, has an unknown key, lacks one, or holds no sorting model.
        """
    @staticmethod
    def from_json(text: str) -> SortingModel:
        """Read the text of a model file.

        Parameters
        ----------
        text : str
            JSON.

        Returns
        -------
        SortingModel
            The model.

        Raises
        ------
        ModelError
            As `load`.
        """
    def to_json(self) -> str:
        """Return the model file as text, JSON."""
    def save(self, path: _Path) -> None:
        """Write a model file; `load` gives an equal model back.

        Parameters
        ----------
        path : str or os.PathLike
            Where to write; an existing file is replaced.

        Raises
        ------
        ModelError
            If the file cannot be written.
        """
    def to_pomdp(self, path: _Path) -> None:
        """Write the model as a flat POMDP in Cassandra's format, which other solvers read.

        A state is the class (with its mode) at every position, with the viewpoint in front unless all
        viewpoints are alike in legal moves and their costs and no scan follows a decision: N^H or K N^H
        states. The actions are the K moves and B decisions; the observations are the Z^H label vectors, and
        ``nothing`` after a decision that no scan follows. Such a file has no forbidden actions: a move that
        `travel` forbids costs (r_max + r_min) / (1 - discount), so that it never pays. The camera starts at
        viewpoint 0.

        Parameters
        ----------
        path : str or os.PathLike
            Where to write; an existing file is replaced.

        Raises
        ------
        ModelError
            For more than two million pairs of state and observation, for `repeat` or `information_gain` above
            0 (such states hold no labels, such rewards no beliefs), or if the file cannot be written.

        References
        ----------
        Cassandra, "POMDP file format", http://www.pomdp.org/code/pomdp-file-spec.html
        """
    def replace(self, **changes: Any) -> SortingModel:
        """Return the same model with other settings.

        Parameters
        ----------
        **changes
            Parameters of the constructor. A new `p_obs` comes without the `counts` and `smoothing` of the old
            one unless they are given too.

        Returns
        -------
        SortingModel
            The changed model.

        Raises
        ------
        TypeError
            For a parameter that the constructor does not have.
        ModelError
            As the constructor.

        Examples
        --------
        >>> from beltsort.models import paper
        >>> paper().replace(r_min=500).r_min
        500.0
        """
    def with_positions(self, positions: int) -> SortingModel:
        """Return the same model with the first belt positions only.

        Parameters
        ----------
        positions : int
            How many to keep, 1 to H.

        Returns
        -------
        SortingModel
            The smaller model.

        Raises
        ------
        ArgumentError
            For less than 1 or more than H.
        """
    @property
    def classes(self) -> list[str]:
        """Names of the classes, list of length L."""
    @property
    def viewpoints(self) -> list[str]:
        """Names of the viewpoints, list of length K."""
    @property
    def positions(self) -> int:
        """H, the number of belt positions that one scan sees."""
    @property
    def labels(self) -> list[str]:
        """Names of the labels that a look may yield, list of length Z; the classes unless given."""
    @property
    def bins(self) -> list[str]:
        """Names of the bins of decisions, list of length B; the classes unless given."""
    @property
    def reward(self) -> NDArray[np.float64]:
        """Worth of putting class c into bin b, float64 of shape (B, L), ``[bin, class]``.

        Without `reward` it follows from `r_max` and `r_min`.
        """
    @property
    def modes(self) -> list[list[float]]:
        """Weights of the modes of each class, a list per class; each sums to 1."""
    @property
    def p_obs(self) -> NDArray[np.float64]:
        """Observation tables as given, read-only float64 of shape (H, K, N, Z).

        N and Z are L unless the model has `modes` or `labels`.
        """
    @property
    def counts(self) -> NDArray[np.uint64] | None:
        """The label counts behind `p_obs`, read-only uint64 of shape (H, K, N, Z), or None."""
    @property
    def r_max(self) -> float:
        """Reward of a right decision; of a model with `reward` its largest entry."""
    @property
    def r_min(self) -> float:
        """Penalty of a wrong decision, above 0.

        Of a model with `reward` its smallest entry, with the other sign.
        """
    @property
    def discount(self) -> float:
        """`gamma`, per planner step."""
    @property
    def smoothing(self) -> float | NDArray[np.float64] | None:
        """The pseudo-counts that were added to `counts`.

        A number, read-only float64 of shape (H, K, N, Z), or None.
        """
    @property
    def note(self) -> str:
        """Free text."""
    @property
    def arrival(self) -> NDArray[np.float64]:
        """Prior of the class of an arriving object, float64 of shape (L,); sums to 1."""
    @property
    def motion_cost(self) -> NDArray[np.float64]:
        """Cost of each move, float64 of shape (K, K), ``[start, end]``."""
    @property
    def travel(self) -> list[list[int]]:
        """The viewpoints that one move reaches, one ascending list per viewpoint."""
    @property
    def observe_after_decision(self) -> bool:
        """Whether a scan follows each decision."""
    @property
    def repeat(self) -> NDArray[np.float64]:
        """Probability that a second look only repeats the last label, float64 of shape (H, K)."""
    @property
    def information_gain(self) -> float:
        """`alpha`, reward per nat of entropy that a scan is expected to remove."""
    @property
    def empty(self) -> str | None:
        """The class that stands for an empty cup, or None."""
    @property
    def label_rule(self) -> dict[str, Any] | None:
        """How perception makes a label of what a classifier returns, a new dict, or None.

        Kept beside the tables that were counted with it; planning does not use it.
        """
    def __eq__(self, value: object, /) -> bool: ...
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> SortingModel: ...
    def __deepcopy__(self, _memo: object) -> SortingModel: ...
