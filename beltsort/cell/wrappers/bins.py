"""From labels to the sorter's own numbers of its bins."""

from collections.abc import Sequence
from dataclasses import replace

from beltsort.cell.commands import SortInto
from beltsort.cell.wrappers.layer import Layer, Request, Send


class Bins(Layer):
    """Tells the sorter a bin's number in place of a label.

    Parameters
    ----------
    numbers
        The bin of each label, of the reject bin last if there is one.
    """

    def __init__(self, numbers: Sequence[int]) -> None:
        self._numbers = numbers

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on; a sort, with the bin's number."""
        if isinstance(request.act, SortInto):
            request = replace(request, act=SortInto(self._numbers[request.act.bin]))
        return send(request)
