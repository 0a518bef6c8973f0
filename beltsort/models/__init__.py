"""Models that come with the package."""

from importlib.resources import files

from beltsort._core import SortingModel


def paper() -> SortingModel:
    """Return the paper's instance: four classes of bulbs, three viewpoints, two belt positions.

    The paper prints only three rows of its tables; the others were chosen with similar accuracy, as stated in
    the model's note.

    References
    ----------
    Mezei, Tamás & Buşoniu, "Sorting objects from a conveyor belt using active perception with a POMDP model",
    ECC 2019, Tables I and II.

    Examples
    --------
    >>> from beltsort.models import paper
    >>> paper().viewpoints
    ['p1', 'p2', 'p3']
    """
    return SortingModel.from_json(files(__name__).joinpath("paper.json").read_text("utf-8"))
