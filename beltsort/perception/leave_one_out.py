"""Leave-one-out classification: each entry of a database classified by all the others.

Views of one object, or parts of one scan, are near each other: on objects that it has never seen, a database
errs more often than here.
"""

from dataclasses import dataclass, replace

import numpy as np

from beltsort.errors import DatabaseError
from beltsort.perception.classifier import Match
from beltsort.perception.distances import Values, distances_to
from beltsort.perception.kernel_ridge import KernelRidge, TrainedClassifier
from beltsort.perception.nearest import NearestNeighbour

PERCENTILE = 99.0


def leave_one_out(database: TrainedClassifier) -> list[Match]:
    """Classify every entry by all the others.

    Memory grows with their number, time with its square.

    Raises
    ------
    DatabaseError
        If there is only one entry.

    Examples
    --------
    >>> descriptors = np.eye(4, 308) + np.eye(4, 308)[[1, 0, 3, 3]]
    >>> database = NearestNeighbour.train(descriptors, [0, 0, 1, 0], ["bulb", "cup"])
    >>> [match.label for match in leave_one_out(database)]
    [0, 0, 0, 1]
    """
    if isinstance(database, KernelRidge):
        return database.left_out()
    if len(database.labels) < 2:
        raise DatabaseError("the database has 1 entry, expected at least 2: train on more clouds")
    used = database.bins.any(axis=1)
    bins, matches = database.bins[used], []
    for i, descriptor in enumerate(database.descriptors[:, used]):
        distances = distances_to(database.distance, bins, descriptor)
        distances[i] = np.inf
        matches.append(database.vote(distances))
    return matches


def rejection_threshold(
    database: NearestNeighbour, left_out: list[Match], percentile: float = PERCENTILE
) -> float | None:
    """Return a distance that only the farthest of a class's own entries exceed.

    It is an observed distance, so with fewer than 100 entries none exceeds it. New objects exceed it more
    often, the fewer entries there are and the more similar these are.

    Parameters
    ----------
    database
        The database.
    left_out
        What `leave_one_out` returned for it.
    percentile
        Percentage of entries that lie within the threshold of another entry of their class. If it is low,
        more known objects are rejected; if it is high, more unknown ones get a label.

    Returns
    -------
    float or None
        For `NearestNeighbour.reject`; None if no class has two different entries.
    """
    return _percentile(_own_distances(database, left_out), percentile)


def training_distance(database: NearestNeighbour, left_out: list[Match]) -> float | None:
    """Return `rejection_threshold` of the entries that the others classify right; None if it has no value.

    An entry that is nearer to another class tells how classes are confused, not how near entries of a class
    are: a single mislabelled one would raise the threshold above the distances of all other objects.

    Parameters
    ----------
    database, left_out
        As in `rejection_threshold`.
    """
    pairs = zip(left_out, database.labels, strict=True)
    right = np.array([match.ranking[0] == label for match, label in pairs])
    return _percentile(_own_distances(database, left_out)[right], PERCENTILE)


def _own_distances(database: NearestNeighbour, left_out: list[Match]) -> Values:
    """Return the distance of each entry to the nearest other one of its class, shape (n,)."""
    return np.array(
        [
            np.inf if match.distances is None else match.distances[label]
            for match, label in zip(left_out, database.labels, strict=True)
        ]
    )


def _percentile(distances: Values, percentile: float) -> float | None:
    """Return an observed distance above 0, or None."""
    finite = distances[np.isfinite(distances)]
    threshold = float(np.percentile(finite, percentile, method="higher")) if finite.size else 0.0
    return threshold if threshold > 0.0 else None


def with_rejection(
    database: NearestNeighbour, left_out: list[Match], reject: float | None
) -> tuple[NearestNeighbour, list[Match]]:
    """Return the same database with a rejection threshold, and the leave-one-out classifications with it.

    The database also keeps its `training_distance`.
    """
    labelled = [replace(match, label=match.ranking[0]) for match in left_out]
    kept = replace(database, reject=reject, training_distance=training_distance(database, left_out))
    return kept, [match.within(reject) for match in labelled]


@dataclass(frozen=True)
class Suspect:
    """An entry that is nearer to another class than to its own, so that its label may be wrong.

    Attributes
    ----------
    entry
        Index of the entry in the database.
    other
        Class of the nearest entry.
    distance, own_distance
        To the nearest entry of that class, and to the nearest other entry of the entry's own.
    """

    entry: int
    other: int
    distance: float
    own_distance: float


def suspects(database: NearestNeighbour, left_out: list[Match]) -> list[Suspect]:
    """Return the entries that are nearer to another class, the most suspicious first.

    An entry is the more suspicious, the nearer another class is in proportion to its own. The only entry of a
    class has nothing to be compared with. Many views of one object under a wrong name are near each other:
    not all of them are found.

    Parameters
    ----------
    database
        The database.
    left_out
        What `leave_one_out` returned for it.

    Examples
    --------
    >>> descriptors = np.eye(4, 308) + np.eye(4, 308)[[1, 0, 3, 3]]
    >>> database = NearestNeighbour.train(descriptors, [0, 0, 1, 0], ["bulb", "cup"])
    >>> [(suspect.entry, suspect.other) for suspect in suspects(database, leave_one_out(database))]
    [(3, 1)]
    """
    found = []
    for entry, (match, label) in enumerate(zip(left_out, database.labels.tolist(), strict=True)):
        if match.distances is None or np.isinf(match.distances[label]):
            continue
        own = float(match.distances[label])
        others = match.distances.copy()
        others[label] = np.inf
        other = int(others.argmin())
        if others[other] < own:
            found.append(Suspect(entry, other, float(others[other]), own))
    return sorted(found, key=lambda suspect: suspect.distance / suspect.own_distance)
