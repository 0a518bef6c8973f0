"""Looks grouped by object: what tables with latent modes are fitted to.

Tables of classes need one look at each of many objects. How the looks at *one* object depend on each other
takes several looks at it, three or more: two looks say no more than how often they agree.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.tables.scans import LabelledScan
from beltsort.util.representation import short_repr

Integers = NDArray[np.int64]
Array = NDArray[np.float64]

NONE = -1
"""In arrays of indices: no label, or a mode that is not known."""


@dataclass(frozen=True)
class LooksAtObject:
    """All looks at one object.

    Attributes
    ----------
    true
        The object's class: an index.
    looks
        Of each look, in order: position, viewpoint, and label or None (no label); indices.
    mode
        Name of the object's mode, unique within its class; None if it is not known.
    """

    true: int
    looks: tuple[tuple[int, int, int | None], ...]
    mode: str | None = None


@dataclass(frozen=True)
class TableShape:
    """Numbers of positions H, viewpoints K, classes L and labels Z."""

    positions: int
    viewpoints: int
    classes: int
    labels: int


@dataclass(frozen=True, eq=False)
class RepeatedLooks:
    """Q looks at n objects. `RepeatedLooks.of` makes one; its arrays belong together.

    Attributes
    ----------
    shape
        Numbers of positions, viewpoints, classes and labels.
    true
        Class of each object, shape (n,).
    modes
        Index of each object's mode among `mode_names` of its class, shape (n,); `NONE` if it is not known.
    mode_names
        Names of the known modes of each class, sorted; L tuples.
    objects
        Object of each look, shape (Q,), ascending; the looks at an object are in the order they were made.
    positions, viewpoints, labels
        Of each look, shape (Q,). The label is `NONE` if there was none.

    Examples
    --------
    >>> nut = LooksAtObject(true=0, looks=((0, 0, 0), (0, 0, 1), (0, 0, None)))
    >>> bolt = LooksAtObject(true=1, looks=((0, 0, 1),))
    >>> looks = RepeatedLooks.of([nut, bolt], TableShape(positions=1, viewpoints=1, classes=2, labels=2))
    >>> looks.counts()[:, 0, 0].tolist()  # every label
    [[1, 1], [0, 1]]
    >>> looks.first_counts()[0, 0].tolist()  # the first look at each object, by class
    [[1, 0], [0, 1]]
    """

    shape: TableShape
    true: Integers
    modes: Integers
    mode_names: tuple[tuple[str, ...], ...]
    objects: Integers
    positions: Integers
    viewpoints: Integers
    labels: Integers

    __repr__ = short_repr

    @classmethod
    def of(cls, objects: Sequence[LooksAtObject], shape: TableShape) -> Self:
        """Build the arrays.

        Parameters
        ----------
        objects
            One or more.
        shape
            Numbers of positions, viewpoints, classes and labels.

        Raises
        ------
        ArgumentError
            If there is no object, or an index is out of range.
        """
        if not objects:
            raise beltsort.ArgumentError("there are 0 objects, expected at least one: look at some objects")
        rows = np.array(
            [
                (number, position, viewpoint, NONE if label is None else label)
                for number, each in enumerate(objects)
                for position, viewpoint, label in each.looks
            ],
            dtype=np.int64,
        ).reshape(-1, 4)
        true = np.array([each.true for each in objects], dtype=np.int64)
        _check("class", true, 0, shape.classes)
        _check("position", rows[:, 1], 0, shape.positions)
        _check("viewpoint", rows[:, 2], 0, shape.viewpoints)
        _check("label", rows[:, 3], NONE, shape.labels)
        names = tuple(
            tuple(sorted({each.mode for each in objects if each.true == c and each.mode is not None}))
            for c in range(shape.classes)
        )
        modes = [NONE if each.mode is None else names[each.true].index(each.mode) for each in objects]
        return cls(shape, true, np.array(modes, dtype=np.int64), names, *rows.T)

    def __len__(self) -> int:
        """Return the number of objects."""
        return len(self.true)

    @property
    def known(self) -> bool:
        """Whether the mode of any object is known."""
        return bool((self.modes != NONE).any())

    def labelled(self) -> Integers:
        """Return the number of looks at each object that gave a label, shape (n,)."""
        return np.bincount(self.objects[self.labels != NONE], minlength=len(self)).astype(np.int64)

    def counts(self) -> Integers:
        """Return the number of labels of each object, shape (n, H, K, Z)."""
        shape = self.shape
        counts = np.zeros((len(self), shape.positions, shape.viewpoints, shape.labels), dtype=np.int64)
        seen = self.labels != NONE
        np.add.at(counts, tuple(x[seen] for x in self._index()), 1)
        return counts

    def first_counts(self) -> Integers:
        """Count the first look at each object in each table row by class, shape (H, K, L, Z).

        These are the counts of `beltsort.tables.count`: further looks in a row are not independent of it.
        """
        shape = self.shape
        rows = np.stack([self.objects, self.positions, self.viewpoints])
        first = np.sort(np.unique(rows, axis=1, return_index=True)[1])
        first = first[self.labels[first] != NONE]
        counts = np.zeros((shape.positions, shape.viewpoints, shape.classes, shape.labels), dtype=np.int64)
        cells = (self.positions, self.viewpoints, self.true[self.objects], self.labels)
        np.add.at(counts, tuple(x[first] for x in cells), 1)
        return counts

    def of_objects(self, chosen: Sequence[int] | Integers) -> Self:
        """Return the looks at the given objects, in that order; `mode_names` stay."""
        order = np.asarray(chosen, dtype=np.int64)
        ends = [np.searchsorted(self.objects, order, side) for side in ("left", "right")]
        looks = [np.arange(*both) for both in zip(*ends, strict=True)]
        rows = np.concatenate([*looks, np.empty(0, dtype=np.int64)])
        numbers = np.repeat(np.arange(len(order)), [len(each) for each in looks])
        kept = self._take(rows)
        return replace(kept, true=self.true[order], modes=self.modes[order], objects=numbers)

    def without_modes(self) -> Self:
        """Return the looks as if no mode were known."""
        return replace(self, modes=np.full(len(self), NONE), mode_names=((),) * self.shape.classes)

    def shuffled(self, seed: int) -> Self:
        """Return the same looks, those at each object in a random order."""
        random = np.random.default_rng(seed).random(len(self.objects))
        return self._take(np.lexsort((random, self.objects)))

    def first(self, share: float) -> Self:
        """Return the first looks at each object: the given share of them, rounded up."""
        rank = np.arange(len(self.objects)) - np.searchsorted(self.objects, self.objects)
        number = np.bincount(self.objects, minlength=len(self))[self.objects]
        # A share such as 2/3 of 12 looks must not become 9 by a rounding error.
        return self._take(np.flatnonzero(rank < np.ceil(share * number - 1e-9)))

    def _take(self, rows: Integers) -> Self:
        objects, positions, viewpoints, labels = (x[rows] for x in self._index())
        return replace(self, objects=objects, positions=positions, viewpoints=viewpoints, labels=labels)

    def _index(self) -> tuple[Integers, Integers, Integers, Integers]:
        return self.objects, self.positions, self.viewpoints, self.labels


def looks_at_objects(
    scans: Iterable[LabelledScan], modes: Mapping[str, str] | None = None
) -> list[LooksAtObject]:
    """Group the looks of labelled scans by object.

    Parameters
    ----------
    scans
        In the order they were made. An object is recognised by its name, from every viewpoint and after the
        belt has moved; one without a name or a class is left out.
    modes
        Name of the mode of each object by the object's name, as `Recording.modes` returns it; the modes of
        others are not known.

    Examples
    --------
    >>> scans = [LabelledScan(viewpoint, (1,), ("nut 7",), (viewpoint,)) for viewpoint in (0, 1)]
    >>> looks_at_objects(scans, {"nut 7": "lying"})
    [LooksAtObject(true=1, looks=((0, 0, 0), (0, 1, 1)), mode='lying')]
    """
    looks: dict[tuple[int, str], list[tuple[int, int, int | None]]] = {}
    for scan in scans:
        seen = zip(scan.true, scan.objects, scan.observed, strict=True)
        for position, (true, name, label) in enumerate(seen):
            if true is not None and name is not None:
                looks.setdefault((true, name), []).append((position, scan.viewpoint, label))
    named = modes or {}
    return [LooksAtObject(true, tuple(rows), named.get(name)) for (true, name), rows in looks.items()]


def _check(what: str, indices: Integers, least: int, number: int) -> None:
    wrong = indices[(indices < least) | (indices >= number)]
    if len(wrong):
        raise beltsort.ArgumentError(
            f"a {what} is {wrong[0]}, expected an index from 0 to {number - 1}: give the right numbers of "
            "positions, viewpoints, classes and labels"
        )
