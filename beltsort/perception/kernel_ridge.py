r"""Kernel ridge regression on the distances of a database, which weighs all entries and not the nearest only.

With the distances :math:`d`, the kernel :math:`K_{ij} = \exp(-d(x_i, x_j) / s)` of the n entries and targets
:math:`Y_{ic} = 1` if entry i is of class c, else -1, the coefficients are :math:`A = (K + \lambda I)^{-1} Y`.
A candidate x has the scores :math:`f_c(x) = \sum_i \exp(-d(x_i, x) / s) A_{ic}` and the probabilities
:math:`\mathrm{softmax}(\beta f(x))`, with the sharpness :math:`\beta` for which the probabilities of the
entries are best if each is left out: its scores are then :math:`Y_i - A_i / (K + \lambda I)^{-1}_{ii}`.
"""

from dataclasses import dataclass
from os import PathLike
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort.errors import DatabaseError
from beltsort.geometry import Points
from beltsort.perception.classifier import Match
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.database import read_database, write_database
from beltsort.perception.descriptor import describe
from beltsort.perception.distances import distances_to
from beltsort.perception.nearest import NearestNeighbour
from beltsort.util.extras import extra
from beltsort.util.html import box, table
from beltsort.util.text import in_words

Array = NDArray[np.float64]

WIDTH = 0.3
"""The scale s of the kernel, as a share of the median distance of two entries."""

RIDGE = 0.3
"""Lambda. It and `WIDTH` were chosen by leave-one-out scores of the simulated cell's training objects."""

SHARPNESS = (0.1, 100.0)
"""Bounds of beta; the upper one is taken if all entries are right when they are left out."""

MOST_ENTRIES = 5_000  # memory grows with the square of their number, the time of training with the cube


@dataclass(frozen=True, eq=False)
class KernelRidge:
    """A classifier that returns probabilities, fitted to the descriptors of a database.

    Attributes
    ----------
    database
        Descriptors, labels, classes, configuration, the distance and the rejection threshold. Its `k` is not
        used.
    coefficients
        A, shape (n, L).
    scale
        s, in units of the database's distance.
    sharpness
        Beta. If many entries are views of one object, or parts of one scan, it is too large for objects that
        were not trained on.

    References
    ----------
    R. Rifkin, G. Yeo, T. Poggio, "Regularized least-squares classification", 2003: the method and its
    leave-one-out scores. J. Zhang, M. Marszalek, S. Lazebnik, C. Schmid, "Local features and kernels for
    classification of texture and object categories", IJCV 2007: the kernel of chi-square distances.

    Examples
    --------
    >>> rows = np.repeat(np.eye(2, 308), 3, axis=0)
    >>> classifier = KernelRidge.train(NearestNeighbour.train(rows, [0, 0, 0, 1, 1, 1], ["bulb", "cup"]))
    >>> match = classifier.match(np.eye(2, 308)[1])
    >>> match.label, match.distance, bool(match.probabilities[1] > 0.99)
    (1, 0.0, True)
    """

    database: NearestNeighbour
    coefficients: Array
    scale: float
    sharpness: float

    def __post_init__(self) -> None:
        """Refuse coefficients that do not fit the database, and settings out of range."""
        shape = (len(self.database.labels), len(self.database.classes))
        if self.coefficients.shape != shape or not np.isfinite(self.coefficients).all():
            raise DatabaseError(
                f"coefficients have shape {self.coefficients.shape}, expected {shape}, all finite: "
                "train again"
            )
        for name in ("scale", "sharpness"):
            value = getattr(self, name)
            if not (isinstance(value, float) and 0.0 < value < np.inf):
                raise DatabaseError(f"{name} is {value!r}, expected a finite number above 0: train again")

    def __repr__(self) -> str:
        """Return the classes with their numbers of entries, and the settings."""
        return f"KernelRidge({in_words(self.facts())})"

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        return box("KernelRidge", table([*self.facts().items()], numbers=False))

    def facts(self) -> dict[str, str]:
        """Return what the database holds and the settings, by name."""
        fitted = {"scale": f"{self.scale:.4g}", "sharpness": f"{self.sharpness:.4g}"}
        return self.database.facts() | fitted

    @classmethod
    def train(cls, database: NearestNeighbour) -> "KernelRidge":
        """Fit to the entries of a database.

        Raises
        ------
        DatabaseError
            If there are fewer than two entries, or more than `MOST_ENTRIES`.
        """
        with extra("perception"):
            from scipy.optimize import minimize_scalar  # planning on the command line needs no scipy

        fit = _fit(database)
        found = minimize_scalar(
            lambda log_beta: -_log_probability(np.exp(log_beta) * fit.left_out, database.labels),
            bounds=tuple(np.log(SHARPNESS)),
            method="bounded",
        )
        return cls(database, fit.coefficients, fit.scale, float(np.exp(found.x)))

    @property
    def classes(self) -> tuple[str, ...]:
        """Names of the classes."""
        return self.database.classes

    @property
    def config(self) -> PerceptionConfig:
        """The configuration that the descriptors were computed with."""
        return self.database.config

    @property
    def labels(self) -> NDArray[np.int64]:
        """Class index of each entry, shape (n,)."""
        return self.database.labels

    @property
    def training_distance(self) -> float | None:
        """As in `NearestNeighbour`."""
        return self.database.training_distance

    def beyond_training(self, match: Match) -> bool:
        """As in `NearestNeighbour`."""
        return self.database.beyond_training(match)

    def classify(self, points: Points, camera: Points) -> Match:
        """Describe a candidate with the database's own configuration and match it.

        Parameters and raises as `NearestNeighbour.classify`.
        """
        return self.match(describe(points, camera, self.config))

    def match(self, descriptor: ArrayLike) -> Match:
        """Return the answer for `descriptor`, shape (m,), with probabilities and distances.

        Raises
        ------
        DatabaseError
            If the descriptor has another shape or a value that is negative or not finite.
        """
        distances = self.database.distances(descriptor)
        scores = np.einsum("n,nc->c", np.exp(-distances / self.scale), self.coefficients)
        return self._match(scores, distances)

    def left_out(self) -> list[Match]:
        """Classify every entry by a classifier that was fitted to all the others.

        The sharpness stays that of all entries.
        """
        fit = _fit(self.database)
        distances = fit.distances.copy()
        np.fill_diagonal(distances, np.inf)
        return [self._match(*pair) for pair in zip(fit.left_out, distances, strict=True)]

    def _match(self, scores: Array, distances: Array) -> Match:
        with extra("perception"):
            from scipy.special import softmax

        probabilities = softmax(self.sharpness * scores)
        nearest = self.database.class_distances(distances)
        label = int(probabilities.argmax())
        return Match(label, probabilities, nearest, probabilities).within(self.database.reject)

    def save(self, path: str | PathLike[str]) -> None:
        """Write one .npz file without pickled objects; `load` reads it back exactly.

        Raises
        ------
        DatabaseError
            If the file cannot be written.
        """
        database = self.database
        header = {**database.header, "scale": self.scale, "sharpness": self.sharpness}
        write_database(path, database.descriptors, database.labels, header, self.coefficients)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> "KernelRidge":
        """Read a classifier that `save` wrote.

        Raises
        ------
        DatabaseError
            If the file is missing, damaged, of another version, or no such classifier.
        """
        loaded = load_trained(path)
        if not isinstance(loaded, KernelRidge):
            raise DatabaseError(
                f"{path} holds a nearest-neighbour classifier, expected a kernel ridge one: train again"
            )
        return loaded


TrainedClassifier: TypeAlias = NearestNeighbour | KernelRidge


def load_trained(path: str | PathLike[str]) -> TrainedClassifier:
    """Read a classifier that `save` of either class wrote.

    Raises
    ------
    DatabaseError
        If the file is missing, damaged, of another version, or no classifier's.
    """
    try:
        stored = read_database(path)
        database = NearestNeighbour.of(stored)
        if stored.coefficients is None:
            return database
        return KernelRidge(database, stored.coefficients, stored.header["scale"], stored.header["sharpness"])
    except Exception as reason:  # whatever a parser stumbles over means that the file is damaged
        raise DatabaseError(
            f"cannot read the database {path}: {reason}; "
            "expected a .npz file that NearestNeighbour.save or KernelRidge.save wrote: train again"
        ) from reason


class _Fit(NamedTuple):
    """Coefficients, scores of each entry if it is left out, shape (n, L), distances, shape (n, n), scale."""

    coefficients: Array
    left_out: Array
    distances: Array
    scale: float


def _fit(database: NearestNeighbour) -> _Fit:
    n = len(database.labels)
    if not 2 <= n <= MOST_ENTRIES:
        raise DatabaseError(
            f"the database has {n} entries, expected 2 to {MOST_ENTRIES} for kernel ridge regression: "
            "train on another number of clouds, or use nearest neighbours"
        )
    used = database.bins.any(axis=1)
    bins = np.ascontiguousarray(database.bins[used])
    distances = np.stack([distances_to(database.distance, bins, row[used]) for row in database.descriptors])
    # Entries that are all the same have the median 0; any scale does for them.
    scale = WIDTH * float(np.median(distances[np.triu_indices(n, 1)])) or 1.0
    inverse = np.linalg.inv(np.exp(-distances / scale) + RIDGE * np.eye(n))
    targets = 2.0 * np.eye(len(database.classes))[database.labels] - 1.0
    coefficients = inverse @ targets
    left_out = targets - coefficients / np.diag(inverse)[:, None]
    return _Fit(coefficients, left_out, distances, scale)


def _log_probability(scores: Array, labels: NDArray[np.int64]) -> float:
    """Return the mean logarithm of the true classes' probabilities."""
    with extra("perception"):
        from scipy.special import log_softmax

    return float(log_softmax(scores, axis=1)[np.arange(len(labels)), labels].mean())
