"""`repr` of dataclasses that hold arrays or many entries."""

from dataclasses import Field, fields
from typing import Any, ClassVar, Protocol

import numpy as np

MOST_NUMBERS = 6  # of an array that are shown
MOST_ENTRIES = 8  # of a tuple that are shown


class Dataclass(Protocol):
    """Any dataclass."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


def short_repr(thing: Dataclass) -> str:
    """Return the `repr` of a dataclass with the shape of an array for its numbers.

    To be the `__repr__` of a dataclass. Vectors of a few numbers are shown, and of long tuples the number of
    entries.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass
    ... class Cloud:
    ...     points: np.ndarray
    ...     camera: np.ndarray
    ...     __repr__ = short_repr
    >>> Cloud(np.zeros((1000, 3)), np.array([0.0, 0.5, 1.0]))
    Cloud(points=<shape (1000, 3)>, camera=[0, 0.5, 1])
    """
    shown = (f"{field.name}={_shown(getattr(thing, field.name))}" for field in fields(thing))
    return f"{type(thing).__name__}({', '.join(shown)})"


def _shown(value: object) -> str:
    if isinstance(value, np.ndarray):
        if value.size > MOST_NUMBERS or value.ndim != 1:
            return f"<shape {value.shape}>"
        return f"[{', '.join(f'{number:.4g}' for number in value.tolist())}]"
    if type(value) is tuple:
        if len(value) > MOST_ENTRIES:
            return f"<{len(value)} entries>"
        return f"({', '.join(map(_shown, value))}{',' if len(value) == 1 else ''})"
    return repr(value)
