"""Validation of commands before they reach a device."""

from collections.abc import Sequence

from beltsort.cell.commands import AdvanceTo, CommandError, MoveTo, Outcome, SortInto
from beltsort.cell.diverting import DiversionStatus
from beltsort.cell.wrappers.layer import Divert, DivertRequest, Layer, Request, Send


class Limits(Layer):
    """Rejects unknown viewpoints and bins, and backward advances of the belt.

    Parameters
    ----------
    viewpoints
        Names of the viewpoints.
    bins
        Names of the bins, the reject bin included.
    """

    def __init__(self, viewpoints: Sequence[str], bins: Sequence[str]) -> None:
        self._viewpoints, self._bins = viewpoints, bins
        self._index = 0

    def command(self, send: Send, request: Request) -> float:
        """Pass a valid command on; reject others."""
        match request.act:
            case MoveTo(viewpoint):
                _check_index("viewpoint", viewpoint, self._viewpoints)
            case SortInto(bin):
                _check_index("label", bin, self._bins)
            case AdvanceTo(index):
                self._check_forward(index)
        return send(request)

    def divert(self, send: Divert, request: DivertRequest) -> DiversionStatus:
        """Pass a diversion into a known bin on; reject others."""
        _check_index("label", request.label, self._bins)
        return send(request)

    def _check_forward(self, index: int) -> None:
        if index < self._index:
            raise CommandError(
                f"index is {index}, expected at least {self._index}, the last one brought to the belt end; "
                "the belt moves forward only",
                Outcome.NOT_DONE,
            )
        self._index = index


def _check_index(what: str, index: int, names: Sequence[str]) -> None:
    if not 0 <= index < len(names):
        raise CommandError(
            f"{what} is {index}, expected an index from 0 to {len(names) - 1} ({', '.join(names)})",
            Outcome.NOT_DONE,
        )
