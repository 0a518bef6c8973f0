"""What a sorter reports of the keys that it remembers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from beltsort.cell.commands import Outcome


class KeyStatus(NamedTuple):
    """The status of a key: the outcome, the sorter's name or number of it, and its explanation."""

    outcome: Outcome
    name: str
    text: str


@dataclass(frozen=True)
class Report:
    """The message with which a sorter reports its keys.

    Attributes
    ----------
    kind
        Message type.
    statuses
        Function of a message that returns the status of each key.
    """

    kind: str
    statuses: Callable[[Mapping[str, Any]], dict[str, KeyStatus]]
