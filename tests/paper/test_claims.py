"""Claims on numbers whose truth is known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beltsort import ArgumentError, Belief
from beltsort.paper import (
    FOUR,
    PAPER,
    QUICK,
    TWO,
    Conclusion,
    Estimate,
    claims,
    difference,
    propagated,
    saving,
    slope,
)
from beltsort.paper.beyond import BONUS, beyond_claims
from beltsort.paper.design import Stream, seed_of
from beltsort.paper.instances import sharpened, with_arrival, with_more_positions
from beltsort.paper.policies import RECOMMENDED
from beltsort.paper.statistics import conclude, mean, unpaired

BATCHES = 40
COMMON = np.random.default_rng(0).normal(0.0, 3.0, BATCHES)


def row(positions: int, r_min: float, steps: float, positives: float, **further: Any) -> dict[str, Any]:
    """Outcomes with the batches' common noise, and a little of their own."""
    rng = np.random.default_rng([positions, int(r_min), int(100 * steps), int(100 * positives)])
    own = rng.normal(0.0, 0.2, BATCHES)
    right = np.full(BATCHES, positives) + own / 10
    return {
        "study": "paper", "setting": None, "level": "labels from tables", "instance": "paper",
        "objects": FOUR.name, "positions": positions, "discount": 0.95, "r_min": r_min, "policy": RECOMMENDED,
        "parameter": None, "steps": (steps + COMMON + own).tolist(), "positives": right.tolist(),
        "negatives": (10 - right).tolist(), "returns": (steps + COMMON + own).tolist(), **further,
    }  # fmt: skip


def conclusions(two_steps: float, two_positives: float, growth: float = 10.0) -> dict[str, str]:
    rows = [
        row(
            positions,
            r_min,
            at_50 + growth * np.log10(r_min / 50),
            positives + growth / 20 * np.log10(r_min / 50),
        )
        for positions, at_50, positives in ((1, 40.0, 9.0), (2, two_steps, two_positives))
        for r_min in (5.0, 50.0, 500.0)
    ]
    return {result.claim: str(result.conclusion) for result in claims(rows, "here")}


def test_claims_that_hold() -> None:
    assert set(conclusions(34.0, 9.0).values()) == {"holds"}


def test_claims_that_fail() -> None:
    found = conclusions(44.0, 8.5, growth=-10.0)
    assert set(found.values()) == {"fails"}


def test_a_small_saving_and_a_lost_accuracy_are_told_apart() -> None:
    found = conclusions(38.0, 8.8)
    assert found["two positions need fewer steps"] == "holds"
    assert found["two positions save at least 10 % of the steps"] == "fails"
    assert found["equal accuracy with two positions"] == "fails"


def test_few_batches_say_nothing() -> None:
    assert conclude(Estimate(1.0, 0.0, 2), above=0.0) is Conclusion.OPEN
    assert conclude(Estimate(1.0, 0.0, 10), above=0.0) is Conclusion.HOLDS


def test_a_saving_and_its_error_are_those_of_many_repetitions() -> None:
    rng = np.random.default_rng(1)
    repeated = []
    for _ in range(2000):
        common = rng.normal(0.0, 3.0, 50)
        repeated.append(saving(34 + common + rng.normal(0, 1, 50), 40 + common + rng.normal(0, 1, 50)))
    values = [estimate.value for estimate in repeated]
    assert np.mean(values) == pytest.approx(0.15, abs=0.001)
    assert np.std(values) == pytest.approx(np.mean([e.standard_error for e in repeated]), rel=0.1)
    covered = np.mean([e.interval[0] <= 0.15 <= e.interval[1] for e in repeated])
    assert covered == pytest.approx(0.95, abs=0.02)


def test_p_values_are_uniform_where_nothing_differs() -> None:
    rng = np.random.default_rng(2)
    p = [difference(rng.normal(size=20), rng.normal(size=20)).p for _ in range(2000)]
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.015)


def test_estimates_by_hand() -> None:
    assert slope([0.0, 1.0], [[1.0, 1.0], [3.0, 5.0]]) == Estimate(3.0, 1.0, 2)
    assert unpaired([1.0, 3.0], [1.0, 1.0, 1.0]) == Estimate(1.0, 1.0, 2)
    assert np.isnan(mean([4]).standard_error)
    assert "p unknown" in mean([4]).in_words()
    with pytest.raises(ArgumentError, match=r"\b2 and 3 batches\b"):
        difference([1, 2], [1, 2, 3])


def test_a_study_is_held_against_its_base() -> None:
    rows = [
        row(2, 50.0, 30.0, 9.0, study=BONUS, setting=0.0),
        row(2, 50.0, 33.0, 9.0, study=BONUS, setting=1.0),
    ]
    (found,) = beyond_claims([*rows, row(2, 50.0, 30.0, 9.0, study="positions seen", setting=2.0)])
    assert found.conclusion is Conclusion.HOLDS
    assert found.estimate.value == pytest.approx(3.0, abs=0.2)
    assert "the steps by +2.98" in found.text


def test_instances() -> None:
    model = with_more_positions(PAPER.model, 4)
    np.testing.assert_array_equal(model.p_obs[:2], PAPER.model.p_obs)
    distance = np.abs(model.p_obs - 0.25).mean(axis=(1, 2, 3))
    assert distance[1] > distance[2] > distance[3] > 0.0
    assert with_more_positions(PAPER.model, 1).positions == 1
    np.testing.assert_allclose(sharpened(PAPER.model, 1.0).p_obs, PAPER.model.p_obs)
    assert sharpened(PAPER.model, 2.0).p_obs.max() > PAPER.model.p_obs.max()
    np.testing.assert_allclose(with_arrival(PAPER.model, TWO, 0.5).arrival, [0.375, 0.375, 0.125, 0.125])
    assert TWO.labels(PAPER.model) == [0, 1]
    assert FOUR.labels(PAPER.model) is None


def test_seeds_of_streams_and_parts_differ() -> None:
    seeds = {seed_of(0, stream, *part) for stream in Stream for part in ((), (0,), (1,))}
    assert len(seeds) == 3 * len(Stream)
    with pytest.raises(ArgumentError, match=r"\bseed\b.*-1\b"):
        seed_of(-1, Stream.LABELS)


def test_a_design_without_the_main_point_is_refused() -> None:
    with pytest.raises(ArgumentError, match=r"\b50\b"):
        replace(QUICK, r_min=(5.0,))


def test_the_propagated_belief_is_the_cores() -> None:
    stages = propagated(PAPER.model, [(1, (0, 2))])
    belief = Belief(PAPER.model)
    belief.observe(1, [0, 2])
    np.testing.assert_array_equal(stages[1][1], belief.probabilities)
    np.testing.assert_array_equal(stages[2][1], [belief.probabilities[1], PAPER.model.arrival])
