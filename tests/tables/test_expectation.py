"""EM: its likelihood is that of stepmix and of brute force, and never falls."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import logsumexp

from beltsort.tables.expectation import Array, Mixture, Problem

NEARLY_NONE = 1e-9  # pseudo-looks too few to matter


def drawn_items(seed: int, objects: int, rows: int, labels: int) -> np.ndarray:
    """Draw one label of each object in each row from two modes, shape (n, rows)."""
    rng = np.random.default_rng(seed)
    tables = rng.dirichlet(np.full(labels, 0.5), size=(2, rows))
    modes = rng.random(objects) < 0.35
    return np.array([[rng.choice(labels, p=tables[int(mode), row]) for row in range(rows)] for mode in modes])


def problem_of(items: np.ndarray, labels: int, modes: int, looks: float, objects: float) -> Problem:
    counts = np.eye(labels)[items]
    prior = np.full(counts.shape[1:], looks / labels)
    return Problem(counts, np.ones((len(items), modes), dtype=bool), prior, objects)


def starts(seed: int, number: int, modes: int, rows: int, labels: int) -> Mixture:
    rng = np.random.default_rng(seed)
    tables = rng.dirichlet(np.ones(labels), size=(number, modes, rows))
    return Mixture(np.full((number, modes), 1.0 / modes), tables)


@pytest.mark.slow
def test_likelihood_is_that_of_stepmix() -> None:
    from stepmix import StepMix  # imports scikit-learn and pandas

    items = drawn_items(3, objects=300, rows=5, labels=3)
    oracle = StepMix(2, measurement="categorical", n_init=10, random_state=0, progress_bar=0, abs_tol=1e-12)
    oracle.fit(items)
    problem = problem_of(items, 3, modes=2, looks=NEARLY_NONE, objects=NEARLY_NONE)
    mixture, _ = problem.maximise(starts(0, 10, 2, rows=5, labels=3))
    own = problem.expectation(mixture)[1].max()
    assert own == pytest.approx(300 * oracle.score(items), rel=1e-6)
    # Its own parameters have that likelihood here, too.
    tables = np.array(oracle.get_parameters()["measurement"]["pis"]).reshape(1, 2, 5, 3)
    theirs = Mixture(np.array(oracle.get_parameters()["weights"])[None], np.maximum(tables, 1e-15))
    assert problem.expectation(theirs)[1][0] == pytest.approx(300 * oracle.score(items), rel=1e-9)


def test_likelihood_is_that_of_brute_force() -> None:
    rng = np.random.default_rng(1)
    mixture = starts(2, 1, modes=2, rows=2, labels=3)
    counts = rng.integers(0, 3, size=(4, 2, 3)).astype(np.float64)
    problem = Problem(counts, np.ones((4, 2), dtype=bool), np.ones((2, 3)), 1.0)
    total = 0.0
    for modes in product(range(2), repeat=4):  # every assignment of modes to the four objects
        total += np.prod(
            [mixture.weights[0, m] * np.prod(mixture.tables[0, m] ** counts[o]) for o, m in enumerate(modes)]
        )
    assert problem.expectation(mixture)[1][0] == pytest.approx(np.log(total), rel=1e-12)


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    modes=st.integers(1, 4),
    looks=st.sampled_from([1e-3, 1.0, 8.0]),
    objects=st.sampled_from([1e-3, 1.0]),
)
def test_no_iteration_lowers_the_penalised_likelihood(
    seed: int, modes: int, looks: float, objects: float
) -> None:
    items = drawn_items(seed, objects=25, rows=4, labels=3)
    problem = problem_of(items, 3, modes, looks, objects)
    mixture, values = starts(seed, 3, modes, rows=4, labels=3), []
    for _ in range(15):
        mixture, value = problem.iterate(mixture)
        values.append(value)
    assert np.diff(values, axis=0).min() >= -1e-9 * np.abs(values).max()


def test_the_maximum_is_stationary() -> None:
    items = drawn_items(5, objects=60, rows=3, labels=3)
    problem = problem_of(items, 3, modes=2, looks=2.0, objects=1.0)
    mixture, value = problem.maximise(starts(0, 4, 2, rows=3, labels=3))
    best = mixture.only(int(value.argmax()), np.arange(2))
    rng = np.random.default_rng(0)

    def penalised(weights: Array, tables: Array) -> float:
        near = Mixture(weights / weights.sum(), tables / tables.sum(axis=-1, keepdims=True))
        return float((problem.expectation(near)[1] + problem.penalty(near))[0])

    for _ in range(20):
        tables = best.tables * np.exp(0.05 * rng.normal(size=best.tables.shape))
        weights = best.weights * np.exp(0.05 * rng.normal(size=best.weights.shape))
        assert penalised(weights, tables) < value.max() + 1e-6


def test_known_modes_are_kept() -> None:
    items = drawn_items(7, objects=20, rows=3, labels=3)
    problem = problem_of(items, 3, modes=2, looks=1.0, objects=1.0)
    problem.possible[:10] = [True, False]
    posterior, _ = problem.expectation(starts(0, 1, 2, rows=3, labels=3))
    assert (posterior[0, :10] == [1.0, 0.0]).all()
    assert logsumexp(posterior[0], axis=1).shape == (20,)
    assert (posterior[0, 10:] > 0.0).all()
