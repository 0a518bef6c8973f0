"""Sort six classes of objects into three bins and a manual bin, and plan on the bins.

Classes that share a bin look alike. Several models plan for the same plant:

- bins: six classes, told apart only as far as the bins ask for it;
- merged by hand: three classes, one per bin, whose tables are means over the classes of the bin;
- merged, six labels: the same, but a look still says which of the six classes it took the object for;
- a bin per class: every class has to be told from every other.
"""

import argparse
import math

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.planning.bins import Estimate, sorting_statistics

CLASSES = ["can", "lid", "bottle", "cup", "carton", "paper"]
BINS = ["metal", "plastic", "fibre", "manual"]
BIN_OF = np.array([0, 0, 1, 1, 2, 2])
SIBLING = np.array([1, 0, 3, 2, 5, 4])  # the other class of the same bin
LOOKALIKE = np.array([2, 3, 0, 4, 3, 1])  # a class of another bin that it is most often taken for
CLEAR = np.array([0.9, 0.6, 0.85, 0.65, 0.6, 0.8])
ARRIVAL = [0.25, 0.1, 0.2, 0.2, 0.15, 0.1]
RIGHT, MANUAL = 10.0, -3.0
WRONG = np.array([[0, -10, -100], [-100, 0, -10], [-100, -100, 0]])  # [bin, bin where the object belongs]
POSITIONS, VIEWPOINTS = 4, ["front", "side", "top"]
Floats = NDArray[np.float64]


def tables() -> Floats:
    """Return the observation tables of the classes, shape (H, K, 6, 6).

    `CLEAR` is the share of labels that are classes of the right bin, from the best viewpoint and position;
    three fifths of them are the class itself. The others are classes of other bins, mostly the `LOOKALIKE`.
    """
    viewpoint, position = np.array([1.0, 0.9, 0.8]), 1.0 - 0.03 * np.arange(POSITIONS)
    quality = position[:, None, None, None] * viewpoint[:, None, None]  # (H, K, 1, 1)
    within = CLEAR[:, None] * (0.6 * np.eye(6) + 0.4 * np.eye(6)[SIBLING])
    elsewhere = (1 - CLEAR[:, None]) * (0.8 * np.eye(6)[LOOKALIKE] + 0.05 * (BIN_OF[:, None] != BIN_OF))
    return np.asarray(quality * (within + elsewhere) + (1 - quality) / 6)


def reward_of_bins() -> Floats:
    """Return what each class is worth in each bin, shape (4, 6)."""
    in_bins = WRONG + RIGHT * np.eye(3)
    return np.vstack([in_bins[:, BIN_OF], np.full(6, MANUAL)])


def plant(p_obs: Floats, labels: list[str] | None = None) -> beltsort.SortingModel:
    """Return the plant with these tables."""
    return beltsort.SortingModel(
        CLASSES, VIEWPOINTS, p_obs, labels=labels, bins=BINS, reward=reward_of_bins(), arrival=ARRIVAL
    )


def merged_labels(p_obs: Floats) -> Floats:
    """Return tables whose labels are the bins, shape (H, K, 6, 3)."""
    return np.stack([p_obs[..., b == BIN_OF].sum(axis=-1) for b in range(3)], axis=-1)


def merged_classes(p_obs: Floats) -> Floats:
    """Return tables in which each class looks like the average object of its bin.

    A model with these tables plans as one whose classes are the bins: those of a bin are never told apart.
    """
    prior = np.array(ARRIVAL)
    same = (BIN_OF[:, None] == BIN_OF) * prior
    weights = same / same.sum(axis=1, keepdims=True)  # (6, 6), [class, class of the same bin]
    return np.asarray(np.einsum("nm,hkmz->hknz", weights, p_obs))


def bin_per_class(p_obs: Floats) -> beltsort.SortingModel:
    """Return a plant with six bins and a manual one; an object in the bin of its sibling costs 10."""
    in_bins = WRONG[BIN_OF][:, BIN_OF] - 10.0 * (BIN_OF[:, None] == BIN_OF) + (RIGHT + 10.0) * np.eye(6)
    reward = np.vstack([in_bins, np.full(6, MANUAL)])
    bins = [*CLASSES, "manual"]
    return beltsort.SortingModel(CLASSES, VIEWPOINTS, p_obs, bins=bins, reward=reward, arrival=ARRIVAL)


def mean(sample: Floats) -> Estimate:
    """Return a mean with its standard error."""
    return Estimate(float(sample.mean()), float(sample.std(ddof=1)) / math.sqrt(len(sample)))


def main() -> None:
    """Simulate the plant with each model's plans, on the same objects and labels."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--batches", type=int, default=30)
    parser.add_argument("--trials", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    by_class = tables()
    by_bin = merged_labels(by_class)
    as_bins = plant(by_class)
    # Each name: the model that plans, and the one that draws objects and labels.
    models = {
        "bins": (as_bins, as_bins),
        "merged by hand": (plant(merged_classes(by_bin), BINS[:3]), plant(by_bin, BINS[:3])),
        "merged, six labels": (plant(merged_classes(by_class)), as_bins),
        "a bin per class": (bin_per_class(by_class), bin_per_class(by_class)),
    }
    print(f"Per ten objects, mean ± standard error over {options.batches} batches, seed {options.seed}:")
    steps = {}
    for name, (model, truth) in models.items():
        planner = beltsort.Despot(model, trials=options.trials)
        result = beltsort.evaluate(model, planner, truth=truth, batches=options.batches, seed=options.seed)
        steps[name] = result.steps.astype(np.float64)
        sorting = sorting_statistics(model, result)
        print(f"{name}: {mean(steps[name])} steps, {sorting.right} right, return {mean(result.returns)}")
        if name == "bins":
            print(sorting)
    ratio = steps["bins"].sum() / steps["merged by hand"].sum()
    residuals = steps["bins"] - ratio * steps["merged by hand"]
    error = mean(residuals).standard_error / steps["merged by hand"].mean()
    print(f"steps on bins, as a multiple of those merged by hand: {Estimate(float(ratio), float(error))}")


if __name__ == "__main__":
    main()
