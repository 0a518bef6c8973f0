"""Reading plain JSON data with messages that say where it is wrong."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from beltsort.errors import ViewpointError
from beltsort.util.naming import nearest_of

LONGEST = 60  # characters of a value in a message


def fields_of(value: object, keys: Sequence[str], where: str) -> list[Any]:
    """Return the values of an object that has exactly these keys, in their order."""
    known = ", ".join(keys)
    if not isinstance(value, dict):
        raise ViewpointError(f"{where} is {short(value)}, expected an object with the keys {known}")
    for key in value:
        if key not in keys:
            raise ViewpointError(f"{where} has the unknown key {key!r}; {nearest_of(key, keys)}")
    for key in keys:
        if key not in value:
            raise ViewpointError(f"{where} lacks the key {key!r}; expected {known}")
    return [value[key] for key in keys]


def list_of(value: object, where: str) -> list[Any]:
    """Return a list."""
    if not isinstance(value, list):
        raise ViewpointError(f"{where} is {short(value)}, expected a list")
    return value


def of_type(value: object, kind: type, where: str) -> Any:
    """Return a value of a type; a whole number serves as `float`, truth values are no numbers."""
    kinds = (int, float) if kind is float else (kind,)
    if not isinstance(value, kinds) or (isinstance(value, bool) and kind is not bool):
        raise ViewpointError(f"{where} is {short(value)}, expected a value of type {kind.__name__}")
    return kind(value)


def array_of(value: object, kind: DTypeLike, columns: int | None, where: str) -> NDArray[Any]:
    """Return rows of `columns` entries each, shape (n, columns), or a flat list, shape (n,)."""
    expected = "a list" if columns is None else f"a list of rows of {columns}"
    try:
        array = np.array(list_of(value, where))
    except ValueError as reason:
        raise ViewpointError(f"{where}: {reason}; expected {expected}") from reason
    wanted = np.dtype(kind)
    if array.size == 0:
        array = np.empty((0,) if columns is None else (0, columns), wanted)
    whole_for_real = wanted.kind == "f" and array.dtype.kind == "i"
    shape_fits = array.ndim == 1 if columns is None else array.ndim == 2 and array.shape[1] == columns
    if not shape_fits or not (array.dtype.kind == wanted.kind or whole_for_real):
        raise ViewpointError(
            f"{where} has shape {array.shape} and type {array.dtype}, expected {expected} of {wanted.name}"
        )
    return array.astype(wanted)


def short(value: object) -> str:
    """Return the beginning of a value as text."""
    text = repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
