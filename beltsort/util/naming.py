"""Names that users write: found, or answered with the nearest one."""

from collections.abc import Sequence
from difflib import get_close_matches

from beltsort._core import ArgumentError


def index_of(text: str, names: Sequence[str], what: str) -> int:
    """Find a name, or a number in its place.

    Parameters
    ----------
    text
        What the user wrote.
    names
        The names that there are.
    what
        What they name, for the message.

    Returns
    -------
    int
        Index into `names`.

    Raises
    ------
    ArgumentError
        Listing the names, the nearest one first, if `text` is none of them and no index either.
    """
    if text in names:
        return names.index(text)
    if text.isdecimal() and int(text) < len(names):
        return int(text)
    raise ArgumentError(f"there is no {what} {text!r}; {nearest_of(text, names)}, or 0 to {len(names) - 1}")


def nearest_of(text: str, names: Sequence[str]) -> str:
    """Say which names there are, and which one was probably meant."""
    (nearest,) = get_close_matches(text, names, n=1, cutoff=0.0)
    return f"did you mean {nearest!r}? Known: {', '.join(names)}"
