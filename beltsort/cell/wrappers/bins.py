"""Conversion of bins to the sorter's numbers."""

from collections.abc import Sequence
from dataclasses import replace

from beltsort.cell.commands import SortInto
from beltsort.cell.wrappers.layer import Layer, Request, Send


class Bins(Layer):
    """Replaces the bin of a sort by the sorter's number of it.

    Parameters
    ----------
    numbers
        The sorter's number of each bin; that of the reject bin, if there is one, is the last.
    """

    def __init__(self, numbers: Sequence[int]) -> None:
        self._numbers = numbers

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on; a sort with the bin number."""
        if isinstance(request.act, SortInto):
            request = replace(request, act=SortInto(self._numbers[request.act.bin]))
        return send(request)
