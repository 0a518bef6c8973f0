from typing import Final, final

@final
class Move:
    """`m_k`: move the camera to a viewpoint and scan once.

    Parameters
    ----------
    viewpoint : int
        Index of the viewpoint. Whether the model has it, and whether a move may reach it, is checked where
        the action is used.

    Raises
    ------
    ArgumentError
        If the index is negative.

    Examples
    --------
    >>> import beltsort
    >>> beltsort.Move(2)
    Move(viewpoint=2)
    >>> match beltsort.Move(2):
    ...     case beltsort.Move(viewpoint):
    ...         viewpoint
    2
    """

    __match_args__: Final = ("viewpoint",)
    def __new__(cls, viewpoint: int) -> Move: ...
    @property
    def viewpoint(self) -> int:
        """Index of the viewpoint."""
    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[int]: ...

@final
class Decide:
    """`d_i`: sort the object at the belt end into a bin; the belt advances by one position.

    Parameters
    ----------
    label : int
        Index of the bin: that of the class, unless the model has `bins`. Whether the model has it is checked
        where the action is used.

    Raises
    ------
    ArgumentError
        If the index is negative.

    Examples
    --------
    >>> import beltsort
    >>> beltsort.Decide(1) == beltsort.Decide(label=1)
    True
    """

    __match_args__: Final = ("label",)
    def __new__(cls, label: int) -> Decide: ...
    @property
    def label(self) -> int:
        """Index of the bin."""
    @property
    def bin(self) -> int:
        """Index of the bin, the same as `label`."""
    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[int]: ...

@final
class Wait:
    """Let a tick pass on a moving belt.

    Examples
    --------
    >>> import beltsort
    >>> beltsort.Wait() == beltsort.Wait()
    True
    """

    __match_args__: Final = ()
    def __new__(cls) -> Wait: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[()]: ...

@final
class DecideAt:
    """Sort the object at a place of a moving belt into a bin.

    Parameters
    ----------
    position : int
        Index of the place, 0 nearest to the exit.
    label : int
        Index of the bin: that of the class, unless the model has `bins`.

    Raises
    ------
    ArgumentError
        If an index is negative.

    Examples
    --------
    >>> import beltsort
    >>> beltsort.DecideAt(1, 2)
    DecideAt(position=1, label=2)
    """

    __match_args__: Final = ("position", "label")
    def __new__(cls, position: int, label: int) -> DecideAt: ...
    @property
    def position(self) -> int:
        """Index of the place, 0 nearest to the exit."""
    @property
    def label(self) -> int:
        """Index of the bin."""
    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[int, int]: ...
