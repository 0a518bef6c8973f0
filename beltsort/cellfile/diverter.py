"""The belt that never stops of a cell file, by the name of its back-end."""

from collections.abc import Mapping

from beltsort.cell.diverting import DivertingBelt
from beltsort.cell.wrappers.diverter_bins import NumberedDiverter
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.registry import DIVERTER, backend


def diverter_of(name: str, options: Mapping[str, object], cell: CellDescription) -> DivertingBelt:
    """Return a belt that never stops, whose bins have the indices of the model's.

    Parameters
    ----------
    name
        Name of the back-end.
    options
        Its options.
    cell
        The cell file; its `bins` have the controller's numbers.

    Raises
    ------
    CellFileError
        If there is no such back-end, or if its options are invalid.
    """
    kind = backend(DIVERTER, name)
    belt: DivertingBelt = kind.make(options, cell)
    return NumberedDiverter(belt, cell.bin_numbers) if kind.numbered else belt
