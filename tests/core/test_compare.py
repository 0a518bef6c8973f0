"""compare: the same objects for every policy, and the statistics of pairs."""

import json
import math
from typing import Any

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    Comparison,
    Despot,
    InformationGain,
    Policy,
    SortingModel,
    Threshold,
    compare,
    evaluate,
)
from beltsort.planning.difference import Difference

from .models import random_model
from .policies import LookThenDecide


def policies(model: SortingModel) -> dict[str, Policy]:
    return {
        "careful": Threshold(model, 0.94),
        "hasty": Threshold(model, 0.8),
        "curious": InformationGain(model, 0.9),
    }


@pytest.fixture(scope="module")
def compared(paper: SortingModel) -> Comparison:
    return compare(paper, policies(paper), batches=60, batch_size=5, seed=3)


def test_each_policy_is_evaluated_as_evaluate_would(paper: SortingModel, compared: Comparison) -> None:
    for name, policy in policies(paper).items():
        alone = evaluate(paper, policy, batches=60, batch_size=5, seed=3)
        assert compared.summary()[name] == alone.summary()
        assert np.array_equal(compared.outcomes(name, "returns"), alone.returns)


def test_differences_are_paired(compared: Comparison) -> None:
    for metric in compared.metrics:
        pairs = compared.outcomes("hasty", metric) - compared.outcomes("curious", metric)
        difference = compared.difference("hasty", metric, "curious")
        assert difference.mean == pytest.approx(pairs.mean())
        assert difference.standard_error == pytest.approx(pairs.std(ddof=1) / math.sqrt(60))
        reverse = compared.difference("curious", metric, "hasty")
        assert (reverse.mean, reverse.standard_error) == (-difference.mean, difference.standard_error)
        if difference.standard_error > 0:
            assert difference.z == difference.mean / difference.standard_error


def test_pairing_is_what_shrinks_the_error(paper: SortingModel) -> None:
    alike = {"a": Threshold(paper, 0.94), "b": Threshold(paper, 0.93)}
    comparison = compare(paper, alike, batches=300)
    alone = [s["returns"]["standard_error"] for s in comparison.summary().values()]
    assert comparison.difference("a", "returns").standard_error < 0.8 * math.hypot(*alone)


def test_the_baseline_is_the_first_or_the_one_named(paper: SortingModel, compared: Comparison) -> None:
    assert compared.baseline == "careful"
    assert list(compared.differences()) == ["hasty", "curious"]
    named = compare(paper, policies(paper), batches=2, baseline="curious")
    assert list(named.differences()) == ["careful", "hasty"]


def test_a_policy_does_not_differ_from_itself(paper: SortingModel) -> None:
    twins = {"once": Despot(paper, trials=2, scenarios=20), "again": Despot(paper, trials=2, scenarios=20)}
    comparison = compare(paper, twins, batches=5)
    for difference in comparison.differences()["again"].values():
        assert (difference.mean, difference.standard_error, difference.z) == (0.0, 0.0, 0.0)


def test_extreme_differences() -> None:
    assert Difference(-2.0, 0.0).z == -math.inf
    assert math.isnan(Difference(1.0, math.nan).z)


def test_biased_metrics_are_left_out_or_refused(paper: SortingModel) -> None:
    drawn: dict[str, Any] = {"batches": 2, "true_classes": [0, 1]}
    comparison = compare(paper, policies(paper), **drawn)
    assert "expected_discounted_returns" not in comparison.metrics
    assert "discounted_returns" in comparison.metrics
    with pytest.raises(ArgumentError, match=r"'expected_discounted_returns'.*steps"):
        compare(paper, policies(paper), metrics=["expected_discounted_returns"], **drawn)


def test_as_plain_data(compared: Comparison) -> None:
    data = json.loads(json.dumps(compared.to_dict(), allow_nan=False))
    assert (data["batches"], data["batch_size"], data["seed"], data["baseline"]) == (60, 5, 3, "careful")
    assert data["summary"] == compared.summary()
    steps = compared.difference("hasty", "steps")
    assert data["differences"]["hasty"]["steps"] == {
        "mean": steps.mean,
        "standard_error": steps.standard_error,
        "z": steps.z,
    }


def test_one_batch_has_no_standard_error(paper: SortingModel) -> None:
    data = compare(paper, policies(paper), batches=1).to_dict()
    assert data["summary"]["hasty"]["steps"]["standard_error"] is None
    assert data["differences"]["hasty"]["steps"]["z"] is None
    json.dumps(data, allow_nan=False)


def test_the_table_shows_every_number(compared: Comparison) -> None:
    text = str(compared)
    assert "Per batch of 5, mean ± standard error over 60:" in text
    steps = compared.summary()["hasty"]["steps"]
    assert f"{steps['mean']:.3f} ± {steps['standard_error']:.3f}" in text
    difference = compared.difference("curious", "correct")
    assert f"{difference.mean:+.3f} ± {difference.standard_error:.3f} ({difference.z:+.1f})" in text
    assert len(text.splitlines()) == 2 * (2 + len(compared.metrics))


def test_any_object_that_acts_is_a_policy() -> None:
    model = random_model(0)
    looks = {"once": LookThenDecide(looks=1), "twice": LookThenDecide(looks=2)}
    comparison = compare(model, looks, batches=3, metrics=["steps"])
    assert comparison.difference("twice", "steps").mean == 10
    assert comparison.metrics == ("steps",)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"policies": {}}, "0 policies"),
        ({"baseline": "absent"}, r"policy 'absent'.*careful, hasty, curious"),
        ({"metrics": ["speed"]}, r"metric 'speed'.*steps, correct"),
        ({"batches": 0}, r"\bbatches\b.*\b0\b"),
    ],
)
def test_bad_arguments(paper: SortingModel, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        compare(paper, **{"policies": policies(paper), "batches": 2, **arguments})


def test_unknown_names_are_refused(compared: Comparison) -> None:
    with pytest.raises(ArgumentError, match=r"policy 'careless'.*hasty"):
        compared.difference("careless", "steps")
    with pytest.raises(ArgumentError, match=r"metric 'speed'.*steps, correct"):
        compared.difference("hasty", "speed")


def test_progress_counts_policies(paper: SortingModel) -> None:
    told: list[tuple[int, int]] = []
    compare(paper, policies(paper), batches=2, progress=lambda done, total: told.append((done, total)))
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3)]
