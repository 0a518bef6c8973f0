"""What a scan can show of one belt position."""

from enum import StrEnum


class Finding(StrEnum):
    """What a scan shows of one belt position; only `OBJECT` is worth a label.

    Examples
    --------
    >>> print(Finding.EMPTY)
    empty
    """

    OBJECT = "object"
    """One object, well seen."""

    EMPTY = "empty"
    """Nothing stands above the rim: the scan saw through most of the cup's opening."""

    HIDDEN = "hidden"
    """Neither an object is seen nor most of the cup: something is in the way, or gave no return."""

    TOO_FEW = "too few points"
    """Something stands there, but its normals would say too little."""

    SEVERAL = "several objects"
    """Surfaces too far apart to be one object's."""

    CUT = "cut off"
    """The object reaches the edge of the image."""
