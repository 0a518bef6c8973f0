"""Models that come with the package."""

from difflib import get_close_matches
from importlib.resources import files
from os import PathLike
from pathlib import Path

from beltsort._core import ModelError, SortingModel
from beltsort.util.naming import nearest_of


def paper() -> SortingModel:
    """Return the paper's instance: four classes of bulbs, three viewpoints, two belt positions.

    The paper prints three of the eight blocks (a position and a class, with a row for each viewpoint) of its
    observation tables; the other five are ours, chosen with similar accuracy. The model's note names them.

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


def simulated() -> SortingModel:
    """Return a model of the default simulated cell whose labels have confidence levels, and classes modes.

    It was fitted to many looks at each of several thousand simulated objects; its note says by which command.
    It sorts what the packaged classifier labels (`beltsort.sim.prepare.prepare`).

    Examples
    --------
    >>> from beltsort.models import simulated
    >>> model = simulated()
    >>> len(model.labels) > len(model.classes), all(len(weights) > 1 for weights in model.modes)
    (True, True)
    """
    return SortingModel.from_json(files(__name__).joinpath("simulated_cell_modes.json").read_text("utf-8"))


PACKAGED = {"paper": paper, "simulated": simulated}
FILES_NAMED = 5
"""Most files that the message about a missing model names."""


def load(name: str | PathLike[str]) -> SortingModel:
    """Return the model in a file, or one that comes with the package.

    Parameters
    ----------
    name
        A model file (JSON), or `paper` or `simulated` where there is no file of this name.

    Raises
    ------
    ModelError
        As `SortingModel.load`. Where there is no such file, the message names the nearest JSON files in its
        folder, and, for a name without folder and suffix, the nearest of the packaged models.

    Examples
    --------
    >>> load("paper") == paper()
    True
    """
    path = Path(name)
    if path.exists():
        return SortingModel.load(path)
    if str(name) in PACKAGED:
        return PACKAGED[str(name)]()
    if not path.parent.is_dir():
        raise ModelError(f"{name!s}: there is no directory {path.parent}; correct the path")
    files_there = sorted(str(found) for found in path.parent.glob("*.json"))
    near = get_close_matches(str(path), files_there, n=FILES_NAMED, cutoff=0.0)
    if str(name) == path.stem:
        raise ModelError(
            f"{name!s}: neither a file nor a packaged model; {nearest_of(str(name), [*PACKAGED, *near])}"
        )
    known = nearest_of(str(path), near) if near else f"there is no model file in {path.parent}"
    raise ModelError(f"{name!s}: there is no such file; {known}; packaged models: {', '.join(PACKAGED)}")
