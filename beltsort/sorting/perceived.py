"""What the loop needs of perception, and the labels of the model that follow from it."""

from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

from beltsort._core import ArgumentError, SortingModel
from beltsort.cell import Scan
from beltsort.errors import CellError


class PerceivedPosition(Protocol):
    """What perception reports about one belt position."""

    @property
    def label(self) -> int | None:
        """Index of a label of the perception (`NamesLabels`), or of a class; None if there is no label."""

    @property
    def empty(self) -> bool:
        """Whether nothing was seen there."""

    @property
    def finding(self) -> str:
        """What was found there, or why nothing was, in a word or two."""


Perceive = Callable[[Scan], Sequence[PerceivedPosition]]
"""Function from a scan to one result per position, the belt end first. It may be an object with the names of
its labels (`NamesLabels`)."""


@runtime_checkable
class NamesLabels(Protocol):
    """A perception that names its labels, by which they are found among the model's.

    One whose labels are more than classes, for example a class and a level of confidence, turns each match
    into a label itself.
    """

    @property
    def labels(self) -> Sequence[str]:
        """Names of the labels; `PerceivedPosition.label` is an index into them."""


@runtime_checkable
class TellsPoseFault(Protocol):
    """A perceived position that tells whether the pose of its scan can be right."""

    @property
    def pose_fault(self) -> object | None:
        """What is likely wrong with the pose of the whole scan, as text; None if nothing is."""


def pose_fault_of(perceived: Sequence[PerceivedPosition]) -> str | None:
    """Return what is likely wrong with the pose of a scan; None if nothing, or it is not told."""
    for seen in perceived:
        if isinstance(seen, TellsPoseFault) and seen.pose_fault is not None:
            return str(seen.pose_fault)
    return None


class LabelNumbers:
    """From the labels of a perception to those of a model, by name.

    Parameters
    ----------
    perceive
        The perception. If it does not name its labels, they are the model's classes.
    model
        The model. An empty position gets the label that is named like its class for empty cups, if it has
        both.

    Raises
    ------
    CellError
        If the perception has labels that the model has not, or the other way round: observation tables hold
        only for the labels that they were estimated with.
    """

    def __init__(self, perceive: object, model: SortingModel) -> None:
        labels = model.labels
        self._names = list(perceive.labels if isinstance(perceive, NamesLabels) else model.classes)
        _check_same(self._names, labels, model.empty)
        self._numbers = [labels.index(name) for name in self._names]
        self._empty = labels.index(model.empty) if model.empty in labels else None

    def of(self, seen: PerceivedPosition) -> int | None:
        """Return the index of the model's label, or None if there is no label.

        Raises
        ------
        ArgumentError
            If the perception has no such label.
        """
        if seen.empty and self._empty is not None:
            return self._empty
        if seen.label is None:
            return None
        if not 0 <= seen.label < len(self._numbers):
            raise ArgumentError(
                f"perception returned the label {seen.label}, expected None or an index from 0 to "
                f"{len(self._names) - 1} ({', '.join(self._names)}): correct it"
            )
        return self._numbers[seen.label]


def _check_same(given: list[str], expected: list[str], empty: str | None) -> None:
    missing = [name for name in expected if name not in (*given, empty)]
    unknown = [name for name in given if name not in expected]
    if missing or unknown:
        lacks = f"cannot give {missing}" if missing else f"gives {unknown}, which the model does not have"
        raise CellError(
            f"the model's labels are {expected}, but perception's are {given}: it {lacks}; expected "
            "the same labels: use a perception with the rule of labels that the tables were estimated with, "
            "or estimate the tables with this one"
        )
