"""The data of a cell file made into typed settings."""

from collections.abc import Mapping
from typing import TypeVar

from beltsort.cellfile.problems import CellFileError
from beltsort.util import validation
from beltsort.util.validation import StrictModel

Settings = TypeVar("Settings")


class Section(StrictModel):
    """A table of the cell file."""


def validated(kind: type[Settings], given: Mapping[str, object]) -> Settings:
    """Return plain data as an instance of `kind`.

    Raises
    ------
    CellFileError
        With all problems: unknown and missing keys, values of a wrong type or out of range.

    Examples
    --------
    >>> from beltsort.sorting.rules import Rules
    >>> validated(Rules, {"max_looks": 20}).max_looks
    20
    >>> validated(Rules, {"max_looks": "20"})
    Traceback (most recent call last):
    ...
    beltsort.cellfile.problems.CellFileError: max_looks: is '20', expected a valid integer
    """
    return validation.validated(kind, given, CellFileError)
