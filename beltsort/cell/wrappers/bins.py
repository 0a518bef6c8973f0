"""From labels to the sorter's own numbers of its bins."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from beltsort.cell.wrappers.wrapped import Act, Call


class Bins:
    """Tells the sorter a bin's number in place of a label.

    Parameters
    ----------
    numbers
        The bin of each label, of the reject bin last if there is one.
    """

    def __init__(self, numbers: Sequence[int]) -> None:
        self._numbers = numbers

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on."""
        return act(
            replace(call, target=self._numbers[int(call.target or 0)]) if call.name == "sort" else call
        )
