"""Conversion of labels to the sorter's bin numbers."""

from collections.abc import Sequence
from dataclasses import replace

from beltsort.cell.commands import SortInto
from beltsort.cell.wrappers.layer import Layer, Request, Send


class Bins(Layer):
    """Replaces the label of a sort by the sorter's bin number.

    Parameters
    ----------
    numbers
        Bin number of each label; that of the reject bin, if there is one, is the last.
    """

    def __init__(self, numbers: Sequence[int]) -> None:
        self._numbers = numbers

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on; a sort with the bin number."""
        if isinstance(request.act, SortInto):
            request = replace(request, act=SortInto(self._numbers[request.act.bin]))
        return send(request)
