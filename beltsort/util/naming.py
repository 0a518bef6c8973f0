"""Look-up of names, with suggestions for unknown ones."""

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from functools import wraps
from inspect import signature
from operator import attrgetter
from typing import TypeVar

from beltsort import _core
from beltsort._core import ArgumentError

T = TypeVar("T")


def index_of(text: str, names: Sequence[str], what: str) -> int:
    """Return the index of a name, given as the name or the index.

    Parameters
    ----------
    text
        A name, or a decimal index.
    names
        The known names.
    what
        The kind of name, for the error message.

    Returns
    -------
    int
        Index into `names`.

    Raises
    ------
    ArgumentError
        If `text` is neither a known name nor an index; the message suggests the nearest name.
    """
    if text in names:
        return names.index(text)
    if text.isdecimal() and int(text) < len(names):
        return int(text)
    raise ArgumentError(f"there is no {what} {text!r}; {nearest_of(text, names)}, or 0 to {len(names) - 1}")


def split_names(text: str, names: Sequence[str]) -> list[str]:
    """Split a list at its commas, but not within known names that contain commas.

    Examples
    --------
    >>> split_names("nut, sure,bolt", ["nut, sure", "bolt"])
    ['nut, sure', 'bolt']
    """
    parts, found = text.split(","), []
    while parts:
        lengths = range(len(parts), 1, -1)
        length = next((n for n in lengths if ",".join(parts[:n]) in names), 1)
        found.append(",".join(parts[:length]))
        parts = parts[length:]
    return found


def nearest_of(text: str, names: Sequence[str]) -> str:
    """Return a message that suggests the nearest name and lists all names."""
    return f"did you mean {nearest_name(text, names)!r}? Known: {', '.join(names)}"


def nearest_name(text: str, names: Iterable[str]) -> str:
    """Return the name that is most similar to a text."""
    (nearest,) = get_close_matches(text, list(names), n=1, cutoff=0.0)
    return nearest


def unknown_keyword(owner: str, unknown: Mapping[str, object]) -> str:
    """Return a message on a keyword that a function or a constructor of the extension does not have.

    Parameters
    ----------
    owner
        Its name in `beltsort._core`.
    unknown
        The keywords that it does not have, at least one; the first is named.

    Examples
    --------
    >>> unknown_keyword("Threshold", {"tresh": 0.9})
    "Threshold has no parameter 'tresh'; did you mean 'threshold'? Known: model, threshold, viewpoint"
    """
    parameters = [name for name in signature(attrgetter(owner)(_core)).parameters if name != "self"]
    return _no_parameter(owner, next(iter(unknown)), parameters)


def suggests_keywords(kind: type[T]) -> type[T]:
    """Let a dataclass refuse a keyword that is no field of it with the nearest one that is, in a `TypeError`.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @suggests_keywords
    ... @dataclass
    ... class Size:
    ...     width: float = 1.0
    ...     height: float = 1.0
    >>> Size(hight=2.0)
    Traceback (most recent call last):
    TypeError: Size has no parameter 'hight'; did you mean 'height'? Known: width, height
    """
    init = vars(kind)["__init__"]
    parameters = [name for name in signature(init).parameters if name != "self"]

    @wraps(init)
    def checked(self: T, *given: object, **keywords: object) -> None:
        for keyword in keywords:
            if keyword not in parameters:
                raise TypeError(_no_parameter(kind.__name__, keyword, parameters))
        init(self, *given, **keywords)

    type.__setattr__(kind, "__init__", checked)  # an assignment would have to be of the same type
    return kind


def _no_parameter(owner: str, keyword: str, parameters: Sequence[str]) -> str:
    return f"{owner} has no parameter {keyword!r}; {nearest_of(keyword, parameters)}"
