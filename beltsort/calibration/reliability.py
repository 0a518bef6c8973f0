r"""How well beliefs are calibrated: reliability curve, calibration error, Brier score.

A pair is a belief p in a class and whether the object is of it (y = 1) or not (y = 0). Pairs are put into the
bins of `EDGES`, for the calibration error (ECE) of `beltsort.util.calibration_error`; with n pairs,

.. math:: \text{Brier} = \frac{1}{n} \sum (p - y)^2 .

An ECE is never 0, since a share of few outcomes differs from its probability. So it is given with the value
expected by chance: outcomes are drawn from the beliefs, with one random number for each object, which leaves
its pairs as dependent as one truth makes them. The Brier score of calibrated beliefs is the mean of
p (1 - p); it needs no bins. Errors and bands come from a bootstrap of objects, not of pairs.

If beliefs are posterior probabilities, every pair is calibrated given all that was seen before it, whatever
policy chose the looks and the moment to decide; so pairs of all steps may be thrown together.

References
----------
J. Bröcker, L. A. Smith, "Increasing the reliability of reliability diagrams", Weather and
Forecasting 22 (2007) (chance bands). D. J. Spiegelhalter, "Probabilistic prediction in patient management and
clinical trials", Statistics in Medicine 5 (1986) (expected Brier score).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort import ArgumentError
from beltsort.util.calibration_error import EDGES, bins_of, error_of_bins
from beltsort.util.text import number_or_none

Array = NDArray[np.float64]

DRAWS = 1000
TAILS = (2.5, 97.5)  # percentiles: 95 % bands


class Pairs:
    """Beliefs about objects whose class is known.

    Parameters
    ----------
    beliefs
        Probabilities, shape (n, m): of m classes that exclude each other. With m = 1, of a single one.
    true
        Whether the object was of that class, shape (n, m).
    objects
        Index of the object that each row is about, shape (n,).
    total
        Number of objects, those without a row included.

    Raises
    ------
    ArgumentError
        If there is no pair, shapes do not fit, or a number is out of range.
    """

    def __init__(self, beliefs: ArrayLike, true: ArrayLike, objects: ArrayLike, total: int) -> None:
        self.beliefs = np.atleast_2d(np.asarray(beliefs, dtype=np.float64))
        self.true = np.atleast_2d(np.asarray(true, dtype=bool))
        self.objects = np.asarray(objects, dtype=np.int64)
        self.total = total
        shapes = (self.beliefs.shape, self.true.shape, self.objects.shape)
        if shapes != (shapes[0], shapes[0], shapes[0][:1]) or self.beliefs.size == 0:
            raise ArgumentError(
                f"beliefs, truths and objects have the shapes {shapes}, expected (n, m), (n, m) and (n,), n "
                "and m at least 1"
            )
        if not (np.all(self.beliefs >= 0.0) and np.all(self.beliefs <= 1.0 + 1e-9)):
            raise ArgumentError("a belief is no probability, expected numbers from 0 to 1")
        if self.objects.min() < 0 or self.objects.max() >= total:
            raise ArgumentError(f"an object's index is out of range, expected 0 to {total - 1}")

    @property
    def bins(self) -> NDArray[np.int64]:
        """Index of each belief's bin, shape (n, m)."""
        return bins_of(self.beliefs)

    def drawn(self, rng: np.random.Generator) -> NDArray[np.bool_]:
        """Draw outcomes from the beliefs, with one random number for each object; shape (n, m)."""
        chosen = rng.random(self.total)[self.objects, np.newaxis]
        upper = np.cumsum(self.beliefs, axis=1)
        drawn: NDArray[np.bool_] = (chosen < upper) & (chosen >= upper - self.beliefs)
        return drawn


@dataclass(frozen=True, eq=False)
class Reliability:
    """A reliability curve, and the numbers that sum it up.

    Attributes
    ----------
    pairs, objects
        How many.
    counts, belief, share
        Pairs, mean belief and share that came true, by bin; NaN in an empty one.
    band
        95 % bootstrap band of the share, shape (2, bins).
    chance
        Range that holds 95 % of the shares if beliefs are calibrated, shape (2, bins).
    ece, ece_error
        Expected calibration error, and its standard error.
    ece_chance, ece_p
        Its mean if beliefs are calibrated, and the probability that chance alone makes it as large.
    brier, brier_error
        Brier score, and its standard error.
    brier_expected
        The Brier score if beliefs are calibrated.
    brier_excess_error
        Standard error of `brier` minus `brier_expected`.
    resampled_ece
        ECE of each bootstrap sample, shape (`DRAWS`,): two arms that sorted the same objects share samples.
    """

    pairs: int
    objects: int
    counts: NDArray[np.int64]
    belief: Array
    share: Array
    band: Array
    chance: Array
    ece: float
    ece_error: float
    ece_chance: float
    ece_p: float
    brier: float
    brier_error: float
    brier_expected: float
    brier_excess_error: float
    resampled_ece: Array

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the samples as plain data, fit for JSON."""
        curve = ("counts", "belief", "share")
        single = ("pairs", "objects", *(name for name in vars(self) if name.startswith(("ece", "brier"))))
        return {
            **{name: getattr(self, name) for name in single},
            "edges": list(EDGES),
            **{name: _plain(getattr(self, name)) for name in curve},
            **{name: [_plain(end) for end in getattr(self, name)] for name in ("band", "chance")},
        }


def reliability(pairs: Pairs, seed: int = 0) -> Reliability:
    """Return how well beliefs are calibrated.

    Parameters
    ----------
    pairs
        The beliefs.
    seed
        Of the bootstrap and of the draws by chance.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> beliefs = rng.uniform(0.5, 1.0, (2000, 1))
    >>> calibrated = reliability(Pairs(beliefs, rng.random((2000, 1)) < beliefs, np.arange(2000), 2000))
    >>> overconfident = reliability(Pairs(beliefs, rng.random((2000, 1)) < 0.75, np.arange(2000), 2000))
    >>> f"{calibrated.ece:.3f}, by chance {calibrated.ece_chance:.3f}; {overconfident.ece:.3f}"
    '0.013, by chance 0.017; 0.109'
    """
    rng = np.random.default_rng(seed)
    tally = _Tally(pairs)
    resampled = rng.multinomial(pairs.total, np.full(pairs.total, 1.0 / pairs.total), size=DRAWS)
    counts = resampled @ tally.counts
    belief, hits = resampled @ tally.belief, resampled @ tally.hits
    by_chance = np.stack([tally.binned(pairs.drawn(rng)) for _ in range(DRAWS)])
    whole = tally.counts.sum(axis=0), tally.belief.sum(axis=0), tally.hits.sum(axis=0)
    ece, eces = error_of_bins(*whole), error_of_bins(counts, belief, hits)
    chances = error_of_bins(whole[0], whole[1], by_chance)
    n = counts.sum(axis=1)
    brier, excess = resampled @ tally.brier / n, resampled @ (tally.brier - tally.spread) / n
    with np.errstate(invalid="ignore", divide="ignore"):
        return Reliability(
            pairs=pairs.beliefs.size,
            objects=pairs.total,
            counts=whole[0],
            belief=whole[1] / whole[0],
            share=whole[2] / whole[0],
            band=_percentiles(hits / counts),
            chance=_percentiles(by_chance / whole[0]),
            ece=float(ece),
            ece_error=float(eces.std()),
            ece_chance=float(chances.mean()),
            ece_p=float((1 + (chances >= ece).sum()) / (1 + DRAWS)),
            brier=float(tally.brier.sum() / pairs.beliefs.size),
            brier_error=float(brier.std()),
            brier_expected=float(tally.spread.sum() / pairs.beliefs.size),
            brier_excess_error=float(excess.std()),
            resampled_ece=eces,
        )


class _Tally:
    """Sums over the pairs of each object: by bin, shape (objects, bins), and over all, shape (objects,)."""

    def __init__(self, pairs: Pairs) -> None:
        self._bins = pairs.bins.ravel()
        self._cells = (pairs.objects[:, np.newaxis] * (len(EDGES) - 1) + pairs.bins).ravel()
        self._shape = (pairs.total, len(EDGES) - 1)
        self.counts = self._sum(np.ones(pairs.beliefs.shape)).astype(np.int64)
        self.belief = self._sum(pairs.beliefs)
        self.hits = self._sum(pairs.true)
        self.brier = self._sum((pairs.beliefs - pairs.true) ** 2).sum(axis=1)
        self.spread = self._sum(pairs.beliefs * (1.0 - pairs.beliefs)).sum(axis=1)

    def binned(self, values: NDArray[Any]) -> Array:
        """Sum over all pairs of each bin."""
        return np.bincount(self._bins, values.ravel(), self._shape[1]).astype(np.float64)

    def _sum(self, values: NDArray[Any]) -> Array:
        sums = np.bincount(self._cells, values.ravel(), self._shape[0] * self._shape[1])
        return sums.astype(np.float64).reshape(self._shape)


def _percentiles(shares: Array) -> Array:
    """Return both ends of the 95 % bands, shape (2, bins); NaN where no sample has a pair."""
    ends = np.full((2, shares.shape[1]), np.nan)
    for b, column in enumerate(shares.T):
        if np.isfinite(column).any():
            ends[:, b] = np.nanpercentile(column, TAILS)
    return ends


def _plain(numbers: NDArray[Any]) -> list[float | None]:
    return [number_or_none(number) for number in numbers.tolist()]
