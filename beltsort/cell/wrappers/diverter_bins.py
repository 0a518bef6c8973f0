"""Conversion of bins to the controller's numbers, for a belt that never stops."""

from collections.abc import Sequence

from beltsort.cell.commands import TIMEOUT
from beltsort.cell.diverting import BeltReading, DiversionStatus, DivertingBelt
from beltsort.cell.protocols import Health


class NumberedDiverter:
    """A `DivertingBelt` that replaces the bin of a diversion by the controller's number of it.

    Parameters
    ----------
    belt
        The belt.
    numbers
        The controller's number of each bin; that of the reject bin, if there is one, is the last.
    """

    def __init__(self, belt: DivertingBelt, numbers: Sequence[int]) -> None:
        self._belt, self._numbers = belt, numbers

    @property
    def device(self) -> DivertingBelt:
        """The belt, which gets the numbers."""
        return self._belt

    def health(self) -> Health:
        """Return the belt's health."""
        return self._belt.health()

    def stop(self) -> None:
        """Stop the belt."""
        self._belt.stop()

    def reading(self, *, timeout: float = TIMEOUT) -> BeltReading:
        """Return the belt's reading."""
        return self._belt.reading(timeout=timeout)

    def divert(
        self,
        command_id: str,
        *,
        number: int,
        coordinate: float,
        label: int,
        boot_id: str,
        timeout: float = TIMEOUT,
    ) -> DiversionStatus:
        """Queue a diversion into the bin with the index `label`."""
        return self._belt.divert(
            command_id,
            number=number,
            coordinate=coordinate,
            label=self._numbers[label],
            boot_id=boot_id,
            timeout=timeout,
        )

    def diversion(self, command_id: str, *, boot_id: str, timeout: float = TIMEOUT) -> DiversionStatus:
        """Return the state of a diversion."""
        return self._belt.diversion(command_id, boot_id=boot_id, timeout=timeout)
