"""Nearest neighbours in a database of descriptors."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort.errors import DatabaseError
from beltsort.geometry import Points
from beltsort.perception.checks import as_array
from beltsort.perception.classifier import Match
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.database import MOST_ENTRIES, Stored, read_database, write_database
from beltsort.perception.descriptor import describe, length_of
from beltsort.perception.distances import DISTANCES, distances_to
from beltsort.perception.vfh import Histogram
from beltsort.util.html import box, table
from beltsort.util.text import in_words


@dataclass(frozen=True, eq=False)
class NearestNeighbour:
    """k-nearest-neighbour classifier of descriptors; ties go to the class with the nearest descriptor.

    A score is a class's share of these `k` votes.

    Attributes
    ----------
    descriptors
        Shape (n, m); m is 308, or 311 with the size (`PerceptionConfig.descriptor`).
    labels
        Class index of each descriptor, shape (n,).
    classes
        Names of the classes.
    config
        The configuration that the descriptors were computed with.
    distance
        `chi2`, `l1` or `l2`, see `beltsort.perception.distances`.
    k
        Number of neighbours that vote. Many outvote an outlier, but also a class with few entries.
    reject
        A candidate gets no label if every entry of the winning class is farther away than this; None: it
        always gets one. `rejection_threshold` finds a value.
    training_distance
        A distance to the nearest entry of its own class that hardly an entry exceeds
        (`beltsort.perception.leave_one_out`), or None if it was not computed. A candidate farther away is
        unlike all that was trained on.

    References
    ----------
    M. Muja, R. B. Rusu, G. Bradski, D. Lowe, "REIN - a fast, robust, scalable recognition infrastructure",
    ICRA 2011: VFH, nearest neighbours and the chi-square distance.

    Examples
    --------
    >>> database = NearestNeighbour.train(np.eye(2, 308), [0, 1], ["bulb", "cup"])
    >>> match = database.match(np.eye(2, 308)[1])
    >>> match.label, match.distance, match.runner_up, match.scores.tolist()
    (1, 0.0, 2.0, [0.0, 1.0])
    """

    descriptors: NDArray[np.float64]
    labels: NDArray[np.int64]
    classes: tuple[str, ...]
    config: PerceptionConfig
    distance: str = "chi2"
    k: int = 1
    reject: float | None = None
    training_distance: float | None = None

    def __post_init__(self) -> None:
        """Refuse arrays, classes and settings that do not fit together."""
        self._check_arrays()
        self._check_classes()
        self._check_settings()

    def __repr__(self) -> str:
        """Return the classes with their numbers of entries, and the settings."""
        return f"NearestNeighbour({in_words(self.facts() | self._rule())})"

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        return box("NearestNeighbour", table([*(self.facts() | self._rule()).items()], numbers=False))

    def facts(self) -> dict[str, str]:
        """Return what the database holds and how it compares, by name."""
        numbers = np.bincount(self.labels, minlength=len(self.classes)).tolist()
        of_classes = [f"{name} {number}" for name, number in zip(self.classes, numbers, strict=True)]
        found = {
            "entries": f"{len(self.labels)} ({', '.join(of_classes)})",
            "descriptor": self.config.descriptor,
            "distance": self.distance,
        }
        return found if self.reject is None else found | {"reject": f"{self.reject:.4g}"}

    def _rule(self) -> dict[str, str]:
        return {"k": str(self.k)}

    def _check_arrays(self) -> None:
        n, length = self.labels.size, length_of(self.config)
        if n == 0 or self.descriptors.shape != (n, length) or self.labels.shape != (n,):
            raise DatabaseError(
                f"descriptors and labels have shapes {self.descriptors.shape} and {self.labels.shape}, "
                f"expected (n, {length}) and (n,) with n > 0: give one label for each descriptor, of "
                f"{self.config.descriptor}"
            )
        if n > MOST_ENTRIES:
            raise DatabaseError(f"{n} descriptors, expected at most {MOST_ENTRIES}: train on fewer")
        if not np.isfinite(self.descriptors).all() or (self.descriptors < 0.0).any():
            raise DatabaseError(
                "some descriptors are negative or not finite, expected histograms: compute them with vfh"
            )

    def _check_classes(self) -> None:
        named = all(isinstance(name, str) for name in self.classes)
        if not named or len(set(self.classes)) < len(self.classes):
            raise DatabaseError(f"classes are {list(self.classes)}, expected names, none twice: rename them")
        if self.labels.min() < 0 or self.labels.max() >= len(self.classes):
            raise DatabaseError(
                f"labels range from {self.labels.min()} to {self.labels.max()}, expected 0 to "
                f"{len(self.classes) - 1} for the classes {list(self.classes)}: name every class"
            )

    def _check_settings(self) -> None:
        if self.distance not in tuple(DISTANCES):
            raise DatabaseError(f"distance is {self.distance!r}, expected one of {list(DISTANCES)}")
        if type(self.k) is not int or not 1 <= self.k <= self.labels.size:
            raise DatabaseError(
                f"k is {self.k!r}, expected an integer from 1 to {self.labels.size}, the number of entries: "
                "ask fewer neighbours"
            )
        for name, without in (("reject", "to label everything"), ("training_distance", "if it is not known")):
            distance = getattr(self, name)
            if distance is not None and not 0.0 < distance < np.inf:
                raise DatabaseError(
                    f"{name} is {distance}, expected a finite distance above 0, or None {without}"
                )

    @classmethod
    def train(
        cls,
        descriptors: ArrayLike,
        labels: ArrayLike,
        classes: Sequence[str],
        config: PerceptionConfig | None = None,
        *,
        distance: str = "chi2",
        k: int = 1,
        reject: float | None = None,
        training_distance: float | None = None,
    ) -> "NearestNeighbour":
        """Build a database.

        Parameters
        ----------
        descriptors
            One row for each training cloud, as `describe` returns them, shape (n, m).
        labels
            Class index of each row, shape (n,).
        classes
            Names of the classes.
        config
            The configuration that the descriptors were computed with; default `PerceptionConfig()`.
        distance, k, reject, training_distance
            As the attributes.

        Raises
        ------
        DatabaseError
            If shapes do not fit, a value is not finite or negative, a label has no class, or a setting is
            out of range.
        """
        rows = as_array("descriptors", descriptors, DatabaseError).copy()
        index = as_array("labels", labels, DatabaseError, dtype=None)
        if index.size and index.dtype.kind not in "iu":
            raise DatabaseError(f"labels are {index.dtype}, expected integers: give class indices, not names")
        settings = config or PerceptionConfig()
        return cls(
            rows, index.astype(np.int64), tuple(classes), settings, distance, k, reject, training_distance
        )

    def classify(self, points: Points, camera: Points) -> Match:
        """Describe a candidate with the database's own configuration and match it.

        Parameters
        ----------
        points
            Shape (n, 3), metres, as dense as those that were trained on.
        camera
            The camera's position in the same frame, shape (3,).

        Raises
        ------
        CloudError
            If no descriptor can be computed, see `describe`.
        """
        return self.match(describe(points, camera, self.config))

    def beyond_training(self, match: Match) -> bool:
        """Whether a match is farther than `training_distance`; False if that or the distance is not known."""
        if self.training_distance is None or match.distance is None:
            return False
        return match.distance > self.training_distance

    def match(self, descriptor: ArrayLike) -> Match:
        """Return the answer for `descriptor`, shape (m,); the first of equally near entries comes first.

        Raises
        ------
        DatabaseError
            If the descriptor has another shape or a value that is negative or not finite.
        """
        return self.vote(self.distances(descriptor))

    def distances(self, descriptor: ArrayLike) -> NDArray[np.float64]:
        """Return the distances of `descriptor`, shape (m,), to all entries, shape (n,).

        Raises
        ------
        DatabaseError
            As `match`.
        """
        return distances_to(self.distance, self.bins, _checked(descriptor, length_of(self.config)))

    def vote(self, distances: NDArray[np.float64]) -> Match:
        """Return the answer for given distances to all entries, shape (n,); infinite ones do not vote."""
        near = np.flatnonzero(distances <= np.partition(distances, self.k - 1)[self.k - 1])
        voters = near[np.argsort(distances[near], kind="stable")][: self.k]
        voters = voters[np.isfinite(distances[voters])]
        votes = np.bincount(self.labels[voters], minlength=len(self.classes))
        match = Match(None, votes / max(len(voters), 1), self.class_distances(distances))
        return replace(match, label=match.ranking[0]).within(self.reject)

    def class_distances(self, distances: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distance to each class, shape (L,), given those to all entries, shape (n,)."""
        nearest = np.full(len(self.classes), np.inf)
        np.minimum.at(nearest, self.labels, distances)
        return nearest

    @cached_property
    def bins(self) -> NDArray[np.float64]:
        """The descriptors, one row for each bin, shape (m, n)."""
        return np.ascontiguousarray(self.descriptors.T)

    def save(self, path: str | PathLike[str]) -> None:
        """Write one .npz file without pickled objects; `load` reads it back exactly.

        Raises
        ------
        DatabaseError
            If the file cannot be written.
        """
        write_database(path, self.descriptors, self.labels, self.header)

    @property
    def header(self) -> dict[str, Any]:
        """Everything but the arrays, as plain data for JSON."""
        settings = {name: getattr(self, name) for name in ("classes", *SETTINGS)}
        return {**settings, "config": asdict(self.config)}

    @classmethod
    def load(cls, path: str | PathLike[str]) -> "NearestNeighbour":
        """Read a database that `save` wrote, by this version of beltsort or an earlier one.

        Raises
        ------
        DatabaseError
            If the file is missing, damaged, of another version, or no database.
        """
        try:
            stored = read_database(path)
            if stored.coefficients is not None:
                raise ValueError("it holds a kernel ridge classifier, expected a nearest-neighbour one")
            return cls.of(stored)
        except Exception as reason:  # whatever a parser stumbles over means that the file is damaged
            raise DatabaseError(
                f"cannot read the database {path}: {reason}; "
                "expected a .npz file that NearestNeighbour.save wrote: train again"
            ) from reason

    @classmethod
    def of(cls, stored: Stored) -> "NearestNeighbour":
        """Return the database whose arrays and header are given.

        Raises
        ------
        Exception
            Of any kind, if they do not fit together.
        """
        descriptors, labels, header, _ = stored
        config = PerceptionConfig(**header["config"])
        settings = {name: header[name] for name in SETTINGS if name in header}
        return cls.train(descriptors, labels, header["classes"], config, **settings)


SETTINGS = ("distance", "k", "reject", "training_distance")


def _checked(descriptor: ArrayLike, length: int) -> Histogram:
    histogram: Histogram = as_array("descriptor", descriptor, DatabaseError)
    if histogram.shape != (length,):
        raise DatabaseError(
            f"the descriptor has shape {histogram.shape}, expected ({length},): compute it with describe"
        )
    bad = ~(np.isfinite(histogram) & (histogram >= 0.0))
    if bad.any():
        raise DatabaseError(
            f"the descriptor holds {histogram[bad][0]} in bin {bad.argmax()}, expected finite values, none "
            "negative: compute it with describe"
        )
    return histogram
