"""Conversion of arguments to arrays, and warnings about lengths and poses."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

import beltsort


def as_array(
    name: str, given: ArrayLike, error: type[beltsort.BeltsortError], dtype: DTypeLike | None = np.float64
) -> NDArray[Any]:
    """Return `given` as an array of `dtype` (None: of its own), or raise `error` about `name`."""
    try:
        return np.asarray(given, dtype=dtype)
    except (TypeError, ValueError, OverflowError) as reason:
        raise error(
            f"{name}: {reason}; expected numbers, every row of the same length: give a NumPy array"
        ) from reason


class UnitWarning(UserWarning):
    """Lengths that are plausible in another unit than metres."""


class PoseWarning(UserWarning):
    """A scan does not show the belt where its pose says."""


class FileWarning(UserWarning):
    """A file holds something that is not read or not used."""


@contextmanager
def counted_warnings() -> Iterator[None]:
    """Ignore the warnings of single scans, for a caller that counts pose faults and tells each kind once."""
    with warnings.catch_warnings():
        for category in (PoseWarning, UnitWarning):
            warnings.simplefilter("ignore", category)
        yield


def warn_unless_metres(name: str, length: float, plausible: tuple[float, float]) -> None:
    """Warn about `name` if its `length` lies outside of what is plausible in metres."""
    least, most = plausible
    if not least <= length <= most:
        factor = 0.001 if length > most else 1000.0
        warnings.warn(
            f"{name} is {length:.3g}, expected {least:g} to {most:g} metres: if the lengths are in another "
            f"unit, convert them (lengths * {factor:g}, say)",
            UnitWarning,
            stacklevel=3,
        )
