"""The bins of a cell file, compared with those of the model."""

from beltsort import SortingModel
from beltsort.cell.bins import without_empty
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.problems import CellFileError


def with_bins_of(model: SortingModel, description: CellDescription) -> CellDescription:
    """Return a cell file whose bins are in the order of the model's.

    A last bin of the model that is named like its class for empty cups may be missing: no cup is emptied into
    it.

    Raises
    ------
    CellFileError
        If `bins` is missing although the model's bins are not the classes, or a bin is missing or unknown.
    """
    expected = without_empty(model.bins, model.empty, description.bin_names)
    given = list(description.bins or description.classes)
    missing = [name for name in expected if name not in given]
    unknown = [name for name in given if name not in expected]
    if missing or unknown:
        raise CellFileError.of("bins", _problem(description, expected, missing, unknown))
    if not description.bins:
        return description
    return description.model_copy(update={"bins": {name: description.bins[name] for name in expected}})


def _problem(
    description: CellDescription, expected: list[str], missing: list[str], unknown: list[str]
) -> str:
    given, remedy = list(description.bins), f"expected {expected}: give the sorter's number of each"
    if not given:
        return f"is missing, and the model's bins are not the classes {list(description.classes)}; {remedy}"
    if set(given) == set(description.classes):
        return f"are given for the classes {given}, but the model has bins of its own; {remedy}"
    lacks = [f"no {missing}"] * bool(missing) + [f"{unknown}, which the model does not have"] * bool(unknown)
    return f"are given for {given}: {' and '.join(lacks)}; {remedy}"
