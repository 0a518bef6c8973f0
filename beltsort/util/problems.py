"""What is wrong with data that a user wrote; `validation` finds it, and this file does without pydantic."""

from collections.abc import Sequence
from typing import NamedTuple


class Problem(NamedTuple):
    """One thing that is wrong.

    Attributes
    ----------
    where
        The keys that lead to it, `belt.spacing` or `viewpoints[1].name`; empty for the data as a whole.
    what
        What was found, what is expected, what to do.
    """

    where: str
    what: str


def listed(problems: Sequence[Problem]) -> str:
    """Return a line for each problem."""
    return "\n".join(f"{where}: {what}" if where else what for where, what in problems)
