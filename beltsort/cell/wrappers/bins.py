"""Conversion of bins to the numbers of a sorter, or of a belt that never stops."""

from collections.abc import Sequence
from dataclasses import replace

from beltsort.cell.commands import SortInto
from beltsort.cell.diverting import DiversionStatus
from beltsort.cell.wrappers.layer import Divert, DivertRequest, Layer, Request, Send


class Bins(Layer):
    """Replaces the bin of a sort or a diversion by the device's number of it.

    Parameters
    ----------
    numbers
        The device's number of each bin; that of the reject bin, if there is one, is the last.
    """

    def __init__(self, numbers: Sequence[int]) -> None:
        self._numbers = numbers

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on; a sort with the bin number."""
        if isinstance(request.act, SortInto):
            request = replace(request, act=SortInto(self._numbers[request.act.bin]))
        return send(request)

    def divert(self, send: Divert, request: DivertRequest) -> DiversionStatus:
        """Pass a diversion on with the bin number."""
        return send(replace(request, label=self._numbers[request.label]))
