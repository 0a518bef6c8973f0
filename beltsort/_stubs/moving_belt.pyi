from collections.abc import Sequence
from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort._stubs.model import SortingModel
from beltsort._stubs.moving_belief import MovingBelief

@final
class MovingBelt:
    """A sorting model on a belt that moves while the camera looks.

    Time runs in ticks. A belt of constant speed carries every object one place further every
    `ticks_per_place`, whatever is decided; an object that passes the exit undecided costs `missed`. With
    `advance_ticks` in its place the belt stands, and advances by one place after each decision on the object
    nearest to the exit, as in the paper. An object is seen at the H places of the model's tables and decided
    while it is in reach. A look moves the camera and scans at the end of its ticks, at least one; its cost is
    the model's. The model's discount is per tick.

    Parameters
    ----------
    model : SortingModel
        Classes, tables and rewards. `repeat`, `observe_after_decision` and `information_gain` are refused.
    ticks_per_place : int, optional
        Ticks between two advances of a belt of constant speed.
    advance_ticks : int, optional
        Ticks of a decision and the advance after it, at least one; in place of `ticks_per_place`.
    reach : int, default 1
        Places, from the exit, at which objects can be decided.
    move_ticks : int or array of shape (K, K), default 1
        Ticks of the camera's moves, ``[start, end]``.
    scan_ticks : int, default 0
        Ticks of a scan.
    sort_ticks : int, default 0
        Ticks of a decision, in which the camera waits.
    missed : sequence of L floats, optional
        Price of an object that passes the exit undecided, per class, not negative; if missing, 0 for the
        model's `empty` class, and the largest reward for the others.
    seconds_per_tick : float, optional
        How long a tick lasts; reports use it.

    Raises
    ------
    ArgumentError
        For durations or prices that make no sense.
    ModelError
        For a model with keys that are not supported.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4, seconds_per_tick=0.5)
    >>> belt.look_ticks.tolist(), belt.missed.tolist()
    ([[1]], [10.0, 10.0])
    >>> beltsort.MovingBelt.from_json(belt.to_json()) == belt
    True
    """

    def __new__(
        cls,
        model: SortingModel,
        *,
        ticks_per_place: int | None = None,
        advance_ticks: int | None = None,
        reach: int = 1,
        move_ticks: ArrayLike = 1,
        scan_ticks: int = 0,
        sort_ticks: int = 0,
        missed: Sequence[float] | NDArray[np.float64] | None = None,
        seconds_per_tick: float | None = None,
    ) -> MovingBelt: ...
    @staticmethod
    def load(path: str | PathLike[str]) -> MovingBelt:
        """Read the file of a moving belt.

        Parameters
        ----------
        path : str or os.PathLike
            A model file with one more key, ``moving_belt``: an object with the constructor's keywords.

        Returns
        -------
        MovingBelt
            The belt.

        Raises
        ------
        ModelError
            If the file cannot be read, is not JSON, has an unknown key, or lacks one.
        ArgumentError
            As the constructor.
        """
    @staticmethod
    def from_json(text: str) -> MovingBelt:
        """Read the text of the file of a moving belt.

        Parameters
        ----------
        text : str
            JSON.

        Returns
        -------
        MovingBelt
            The belt.

        Raises
        ------
        ModelError, ArgumentError
            As `load`.
        """
    def to_json(self) -> str:
        """Return the file as text, JSON."""
    def save(self, path: str | PathLike[str]) -> None:
        """Write the file; `load` gives an equal belt back.

        Parameters
        ----------
        path : str or os.PathLike
            Where to write; an existing file is replaced.

        Raises
        ------
        ModelError
            If the file cannot be written.
        """
    def belief(self, objects: int | None = None) -> MovingBelief:
        """Return the belief of a belt full of unseen objects that has just advanced.

        Parameters
        ----------
        objects : int, optional
            How many objects will pass, those at the places included; if missing, the belt never ends.

        Returns
        -------
        MovingBelief
            The belief.

        Raises
        ------
        ArgumentError
            For a negative number.
        """
    @property
    def model(self) -> SortingModel:
        """The model: classes, tables and rewards."""
    @property
    def ticks_per_place(self) -> int | None:
        """Ticks between two advances; None if the belt advances on decisions."""
    @property
    def advance_ticks(self) -> int | None:
        """Ticks of a decision and the advance after it; None for a belt of constant speed."""
    @property
    def reach(self) -> int:
        """Places, from the exit, at which objects can be decided."""
    @property
    def look_ticks(self) -> NDArray[np.uint64]:
        """Ticks of each look, its move and its scan; uint64 of shape (K, K), ``[start, end]``."""
    @property
    def decision_ticks(self) -> int:
        """Ticks of a decision: `sort_ticks`, or those of the advance."""
    @property
    def missed(self) -> NDArray[np.float64]:
        """Price of an object that passes the exit undecided, float64 of shape (L,)."""
    @property
    def seconds_per_tick(self) -> float | None:
        """How long a tick lasts, in seconds, or None."""
    @property
    def settings(self) -> dict[str, Any]:
        """What the belt was made with besides the model, as keywords of the constructor."""
    def __eq__(self, other: object) -> bool: ...
    def __ne__(self, other: object) -> bool: ...
    def __copy__(self) -> MovingBelt: ...
    def __deepcopy__(self, _memo: Any) -> MovingBelt: ...
    def __getnewargs_ex__(self) -> tuple[tuple[SortingModel], dict[str, Any]]: ...
