"""What is given as an array, made one."""

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
