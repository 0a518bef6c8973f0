"""`python -m benchmarks.descriptors`: descriptors and classifiers on objects of the simulated cell.

Trains on some objects and labels others, one look at each. With `-o DB`, the best classifier is written to a
file for `beltsort estimate simulated --classifier DB` and `beltsort calibrate-check`.
"""

from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import log_softmax

from beltsort.perception import KernelRidge, Match, NearestNeighbour, PerceptionConfig, leave_one_out
from beltsort.perception.kernel_ridge import TrainedClassifier
from beltsort.perception.vfh import LENGTH
from beltsort.sim.collect import collect_training

Array = NDArray[np.float64]

SIZED = PerceptionConfig(descriptor="vfh+size")
SEEDS = 2019, 2020
"""Of the objects to train on, those of the packaged classifier, and of those to label."""

LEAST = 1e-12


@dataclass(frozen=True)
class Scores:
    """How one classifier labels objects that it was not trained on.

    Attributes
    ----------
    name
        Descriptor and classifier.
    right
        Whether each label is right, shape (n,), 0 or 1.
    log_loss
        Mean negative logarithm of the true class's probability, nats.
    milliseconds
        To label one descriptor.
    """

    name: str
    right: Array
    log_loss: float
    milliseconds: float


def vfh_only(database: NearestNeighbour) -> NearestNeighbour:
    """Return the database without the sizes."""
    return NearestNeighbour.train(database.descriptors[:, :LENGTH], database.labels, database.classes)


def log_scores(matches: Sequence[Match]) -> Array:
    """Return the logarithms of probabilities, or negative distances where there are none, shape (n, L)."""
    found = []
    for match in matches:
        if match.probabilities is not None:
            found.append(np.log(match.probabilities + LEAST))
        else:
            assert match.distances is not None
            found.append(-match.distances)
    return np.array(found)


def log_loss(scores: Array, labels: NDArray[np.int64], sharpness: float) -> float:
    """Return the mean log-loss of the softmax of `sharpness` times the scores."""
    return -float(log_softmax(sharpness * scores, axis=1)[np.arange(len(labels)), labels].mean())


def scored(name: str, classifier: TrainedClassifier, tested: NearestNeighbour) -> Scores:
    """Label the entries of `tested`; probabilities are calibrated by one factor, on left-out entries."""
    began = perf_counter()
    matches = [classifier.match(row) for row in tested.descriptors]
    milliseconds = 1000.0 * (perf_counter() - began) / len(matches)
    known, labels = log_scores(leave_one_out(classifier)), classifier.labels
    factor = minimize_scalar(
        lambda x: log_loss(known, labels, np.exp(x)), bounds=(-10.0, 3.0), method="bounded"
    )
    right = np.array([match.label for match in matches]) == tested.labels
    loss = log_loss(log_scores(matches), tested.labels, float(np.exp(factor.x)))
    return Scores(name, right.astype(np.float64), loss, milliseconds)


def main() -> None:
    """Print a line for each descriptor and classifier, the paper's first."""
    parser = ArgumentParser(prog="python -m benchmarks.descriptors", description=__doc__)
    parser.add_argument("--train", type=int, default=40, help="objects per class, viewpoint and position")
    parser.add_argument("--test", type=int, default=40, help="others to label")
    parser.add_argument("--workers", type=int, help="processes (default: one for each core)")
    parser.add_argument("-o", "--output", metavar="DB", help="where to write the last classifier")
    arguments = parser.parse_args()
    trained, tested = (
        collect_training(perception=SIZED, objects=objects, seed=seed, workers=arguments.workers)
        for objects, seed in zip((arguments.train, arguments.test), SEEDS, strict=True)
    )
    kernel = KernelRidge.train(trained)
    rows = [
        scored("vfh, nearest", vfh_only(trained), vfh_only(tested)),
        scored("vfh, kernel-ridge", KernelRidge.train(vfh_only(trained)), vfh_only(tested)),
        scored("vfh+size, nearest", trained, tested),
        scored("vfh+size, kernel-ridge", kernel, tested),
    ]
    print(f"{len(trained.labels)} objects to train on, {len(tested.labels)} to label; ± one standard error")
    root = len(tested.labels) ** 0.5
    for row in rows:
        difference = row.right - rows[0].right
        print(
            f"{row.name:24} right {row.right.mean():.3f} ± {row.right.std() / root:.3f}  "
            f"against vfh, nearest {difference.mean():+.3f} ± {difference.std() / root:.3f}  "
            f"log-loss {row.log_loss:.3f}  {row.milliseconds:.2f} ms"
        )
    if arguments.output is not None:
        kernel.save(arguments.output)


if __name__ == "__main__":
    main()
