"""`python -m benchmarks.few_objects`: how well tables of few objects are estimated, by prior."""

import numpy as np

from beltsort.models import paper
from beltsort.tables.counts import Array, Counts
from beltsort.tables.pooling import pooled_prior

OBJECTS = (1, 3, 10, 30, 100)
PRIORS = ("uniform, 1", "uniform, 1/Z", "shrunk by 4 looks", "shrunk, weight chosen")
DRAWS = 100
LEAST = 0.002  # added to the paper's entries, some of which are 0


def truths() -> dict[str, Array]:
    """Return tables by name, shape (H, K, L, L)."""
    of_paper = paper().p_obs + LEAST
    right = np.full((1, 3, 12, 12), 0.03 / 11)
    right[..., np.arange(12), np.arange(12)] = 0.97
    pair = right.copy()
    pair[:, :, 0] = [0.556, 0.404, *[0.004] * 10]
    named = {"the paper's": of_paper, "twelve classes, 0.97 right": right, "with a confused pair": pair}
    return {name: table / table.sum(axis=-1, keepdims=True) for name, table in named.items()}


def divergences(truth: Array, objects: int) -> Array:
    """Return the divergence of the truth from each estimate, mean over rows, shape (draws, priors)."""
    generator = np.random.default_rng(objects)
    rows = truth.shape[:3]
    found = []
    for _ in range(DRAWS):
        empty = np.zeros(rows[:2], dtype=np.int64)
        counts = Counts(generator.multinomial(objects, truth), np.zeros(rows, dtype=np.int64), empty, empty)
        priors = 1.0, 1.0 / truth.shape[-1], pooled_prior(counts, 4.0), pooled_prior(counts)
        tables = [counts.probabilities(prior) for prior in priors]
        found.append([(truth * np.log(truth / table)).sum(axis=-1).mean() for table in tables])
    return np.array(found)


def main() -> None:
    """Print a line for each table and prior: mean and standard error by number of objects in a row."""
    print(f"Kullback-Leibler divergence, nats, of rows with {', '.join(map(str, OBJECTS))} objects")
    for name, truth in truths().items():
        samples = [divergences(truth, objects) for objects in OBJECTS]
        for i, prior in enumerate(PRIORS):
            cells = [f"{s[:, i].mean():.4f} ± {s[:, i].std(ddof=1) / DRAWS**0.5:.4f}" for s in samples]
            print(f"{name:28} {prior:22} {'  '.join(cells)}")


if __name__ == "__main__":
    main()
