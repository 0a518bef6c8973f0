"""Nearest neighbour in a database of descriptors."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort.errors import DatabaseError
from beltsort.perception.checks import as_array
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.vfh import LENGTH, Histogram

VERSION = 1
ARRAYS = ("descriptors", "labels", "header")


@dataclass(frozen=True)
class Match:
    """The answer for one descriptor.

    Attributes
    ----------
    label
        Class of the nearest entry.
    distance
        Distance to it.
    runner_up
        Distance to the nearest entry of any other class, infinite if there is none. Near `distance` means
        doubt.
    """

    label: int
    distance: float
    runner_up: float


@dataclass(frozen=True, eq=False)
class NearestNeighbour:
    r"""The class of the nearest training descriptor.

    The distance is chi-square, :math:`\sum_i (a_i - b_i)^2 / (a_i + b_i)` over bins not empty in both.

    Attributes
    ----------
    descriptors
        Shape (n, 308).
    labels
        Class index of each descriptor, shape (n,).
    classes
        Names of the classes.
    config
        The configuration that the descriptors were computed with.

    References
    ----------
    M. Muja, R. B. Rusu, G. Bradski, D. Lowe, "REIN - a fast, robust, scalable recognition infrastructure",
    ICRA 2011: VFH, nearest neighbours and the chi-square distance.

    Examples
    --------
    >>> import numpy as np
    >>> database = NearestNeighbour.train(np.eye(2, 308), [0, 1], ["bulb", "cup"])
    >>> database.match(np.eye(2, 308)[1])
    Match(label=1, distance=0.0, runner_up=2.0)
    """

    descriptors: NDArray[np.float64]
    labels: NDArray[np.int64]
    classes: tuple[str, ...]
    config: PerceptionConfig

    def __post_init__(self) -> None:
        """Refuse arrays that are no database."""
        n = self.labels.size
        if n == 0 or self.descriptors.shape != (n, LENGTH) or self.labels.shape != (n,):
            raise DatabaseError(
                f"descriptors and labels have shapes {self.descriptors.shape} and {self.labels.shape}, "
                f"expected (n, {LENGTH}) and (n,) with n > 0: give one label for each descriptor"
            )
        if not np.isfinite(self.descriptors).all() or (self.descriptors < 0.0).any():
            raise DatabaseError(
                "some descriptors are negative or not finite, expected histograms: compute them with vfh"
            )
        if self.labels.min() < 0 or self.labels.max() >= len(self.classes):
            raise DatabaseError(
                f"labels range from {self.labels.min()} to {self.labels.max()}, expected 0 to "
                f"{len(self.classes) - 1} for the classes {list(self.classes)}: name every class"
            )

    @classmethod
    def train(
        cls,
        descriptors: ArrayLike,
        labels: ArrayLike,
        classes: Sequence[str],
        config: PerceptionConfig | None = None,
    ) -> "NearestNeighbour":
        """Build a database.

        Parameters
        ----------
        descriptors
            One row for each training cloud, as `describe` returns them, shape (n, 308).
        labels
            Class index of each row, shape (n,).
        classes
            Names of the classes.
        config
            The configuration that the descriptors were computed with; default `PerceptionConfig()`.

        Raises
        ------
        DatabaseError
            If shapes do not fit, a value is no number or no histogram's, or a label has no class.
        """
        rows = as_array("descriptors", descriptors, DatabaseError).copy()
        index = as_array("labels", labels, DatabaseError, dtype=None)
        if index.size and index.dtype.kind not in "iu":
            raise DatabaseError(f"labels are {index.dtype}, expected integers: give class indices, not names")
        return cls(rows, index.astype(np.int64), tuple(classes), config or PerceptionConfig())

    def match(self, descriptor: ArrayLike) -> Match:
        """Return the nearest entry of `descriptor`, shape (308,); the first of equally near ones wins.

        Raises
        ------
        DatabaseError
            If the descriptor has another shape or a value that is negative or not finite.
        """
        histogram = _checked(descriptor)
        seen = histogram > 0.0
        stored, query = self.descriptors[:, seen], histogram[seen]
        distances = ((stored - query) ** 2 / (stored + query)).sum(axis=1)
        distances += self.descriptors[:, ~seen].sum(axis=1)
        nearest = int(distances.argmin())
        label = int(self.labels[nearest])
        others = distances[self.labels != label]
        return Match(label, float(distances[nearest]), float(others.min(initial=np.inf)))

    def save(self, path: str | PathLike[str]) -> None:
        """Write one .npz file without pickled objects; `load` reads it back exactly.

        Raises
        ------
        DatabaseError
            If the file cannot be written.
        """
        header = {"version": VERSION, "classes": self.classes, "config": asdict(self.config)}
        try:
            with Path(path).open("wb") as file:
                np.savez_compressed(
                    file,
                    descriptors=self.descriptors,
                    labels=self.labels,
                    header=np.array(json.dumps(header)),
                )
        except OSError as reason:
            raise DatabaseError(f"cannot write {path}: {reason}; choose a writable path") from reason

    @classmethod
    def load(cls, path: str | PathLike[str]) -> "NearestNeighbour":
        """Read a database that `save` wrote.

        Raises
        ------
        DatabaseError
            If the file is missing, damaged, of another version, or no database.
        """
        try:
            with np.load(Path(path), allow_pickle=False) as stored:
                descriptors, labels, header = (stored[name] for name in ARRAYS)
            fields = json.loads(str(header))
            if fields["version"] != VERSION:
                raise ValueError(f"its version is {fields['version']!r}, expected {VERSION}")
            config = PerceptionConfig(**fields["config"])
            return cls.train(descriptors, labels, fields["classes"], config)
        except Exception as reason:  # whatever a parser stumbles over means that the file is damaged
            raise DatabaseError(
                f"cannot read the database {path}: {reason}; "
                "expected a .npz file that NearestNeighbour.save wrote: train again"
            ) from reason


def _checked(descriptor: ArrayLike) -> Histogram:
    histogram: Histogram = as_array("descriptor", descriptor, DatabaseError)
    if histogram.shape != (LENGTH,):
        raise DatabaseError(
            f"the descriptor has shape {histogram.shape}, expected ({LENGTH},): compute it with describe"
        )
    bad = ~(np.isfinite(histogram) & (histogram >= 0.0))
    if bad.any():
        raise DatabaseError(
            f"the descriptor holds {histogram[bad][0]} in bin {bad.argmax()}, expected finite values, none "
            "negative: compute it with describe"
        )
    return histogram
