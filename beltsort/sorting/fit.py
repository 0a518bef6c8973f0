"""The check that a cell and a model fit."""

from typing import Any

from beltsort._core import SortingModel
from beltsort.cell import Cell, DivertingCell
from beltsort.cell.bins import bin_names_of, without_empty
from beltsort.errors import CellError


def check_fit(cell: Cell | DivertingCell, model: SortingModel) -> None:
    """Check that a cell has the classes, viewpoints, positions and bins of a model.

    Raises
    ------
    CellError
        If it has not.
    """
    bins = bin_names_of(cell)
    pairs: list[tuple[str, Any, Any]] = [
        ("classes", list(cell.classes), without_empty(model.classes, model.empty, cell.classes)),
        ("viewpoints", list(cell.viewpoints), list(model.viewpoints)),
        ("positions", cell.layout.positions, model.positions),
        ("bins", list(bins), without_empty(model.bins, model.empty, bins)),
    ]
    for name, of_cell, of_model in pairs:
        if of_cell != of_model:
            remedy = "give the cell these" if name == "bins" else "estimate the tables with this cell"
            raise CellError(
                f"the cell's {name} are {of_cell}, the model's {of_model}; they must agree, in order: "
                f"{remedy}"
            )
