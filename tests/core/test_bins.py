"""What arrives in the bins: counts that add up, shares that mean what they say, errors that hold."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort import Decide, Evaluation, SortingModel, Threshold, compare, evaluate
from beltsort.planning.bins import sorting_statistics, sorts_into_classes
from beltsort.planning.decisions import right_bins
from tests.laws import cases

from .models import named, random_model
from .policies import Always

REWARD = [[10.0, 10.0, -40.0, -20.0], [-5.0, -90.0, 8.0, 6.0], [-3.0, -3.0, -3.0, -3.0]]
BINS = ["metal", "plastic", "manual"]


def plant(**changes: object) -> SortingModel:
    """Four classes, of which two belong into each of two bins, and a manual bin."""
    return random_model(4, n=4, bins=BINS, reward=REWARD).replace(**changes)


@st.composite
def models(draw: st.DrawFn) -> SortingModel:
    """Models with bins of their own; some rewards are equal, so that a class may belong into several bins."""
    n, bins = draw(st.integers(2, 4)), draw(st.integers(1, 4))
    rows = st.lists(st.integers(-5, 5).map(float), min_size=n, max_size=n)
    reward = draw(st.lists(rows, min_size=bins, max_size=bins))
    reward[0][0] = 9.0
    return random_model(draw(st.integers(0, 1000)), n=n, bins=named("bin", bins), reward=reward)


def played(model: SortingModel, batches: int = 20) -> Evaluation:
    return evaluate(model, Threshold(model, 0.6), batches=batches, batch_size=5, max_looks=4)


@cases(40)
@given(models())
def test_every_object_is_in_one_bin(model: SortingModel) -> None:
    result = played(model)
    statistics = sorting_statistics(model, result)
    assert result.confusion.shape == (20, len(model.bins), len(model.classes))
    assert result.confusion.sum(axis=(1, 2)).tolist() == [5] * 20
    assert statistics.confusion.sum() == pytest.approx(5)
    assert statistics.confusion.sum(axis=1) == pytest.approx([b.objects.value for b in statistics.bins])


@cases(40)
@given(models())
def test_right_and_reward_are_those_of_the_simulation(model: SortingModel) -> None:
    result = played(model)
    statistics = sorting_statistics(model, result)
    correct = result.summary()["correct"]
    assert statistics.right.value == pytest.approx(correct["mean"])
    assert statistics.right.standard_error == pytest.approx(correct["standard_error"])
    moves = result.steps.astype(float) - 5  # each costs 1
    assert statistics.reward.value == pytest.approx(float(np.mean(result.returns + moves)))


@cases(40)
@given(models())
def test_shares_are_weighted_means_of_right_decisions(model: SortingModel) -> None:
    statistics = sorting_statistics(model, played(model))
    arrived = [b.purity.value * b.objects.value for b in statistics.bins if not math.isnan(b.purity.value)]
    assert sum(arrived) == pytest.approx(statistics.right.value)
    belonging = right_bins(model) @ statistics.confusion.sum(axis=0)
    recovered = [b.recovery.value * n for b, n in zip(statistics.bins, belonging, strict=True) if n > 0]
    assert sum(recovered) == pytest.approx(statistics.right.value)
    for found in statistics.bins:
        assert math.isnan(found.purity.value) or 0 <= found.purity.value <= 1
        assert math.isnan(found.recovery.value) or 0 <= found.recovery.value <= 1


def test_bins_in_another_order_have_the_same_statistics() -> None:
    order = [2, 0, 1]
    swapped = plant(bins=[BINS[b] for b in order], reward=[REWARD[b] for b in order])
    here, there = (sorting_statistics(model, played(model)) for model in (plant(), swapped))
    for key in ("objects", "purity", "recovery", "right", "reward"):
        assert there.to_dict()[key] == here.to_dict()[key]
    assert there.confusion.tolist() == here.confusion[order].tolist()


def test_all_in_one_bin() -> None:
    model = plant()
    given_classes = np.tile([0, 1, 2, 3, 0, 0], (3, 1))
    result = evaluate(
        model, Always(Decide(1)), batches=3, batch_size=5, true_classes=given_classes, threads=1
    )
    statistics = sorting_statistics(model, result)
    metal, plastic, manual = statistics.bins
    assert statistics.confusion.tolist() == [[0, 0, 0, 0], [2, 1, 1, 1], [0, 0, 0, 0]]
    assert (plastic.objects.value, plastic.purity.value, plastic.recovery.value) == (5.0, 0.4, 1.0)
    assert math.isnan(metal.purity.value)
    assert metal.recovery.value == 0.0
    assert math.isnan(manual.purity.value)
    assert math.isnan(manual.recovery.value)
    assert statistics.reward.value == -5 * 2 - 90 + 8 + 6
    assert plastic.purity.standard_error == 0.0


def test_errors_of_shares_shrink_with_the_root_of_the_batches() -> None:
    model = plant()
    few, many = (sorting_statistics(model, played(model, batches)) for batches in (400, 6400))
    for a, b in zip(few.bins[:2], many.bins[:2], strict=True):
        assert b.purity.standard_error == pytest.approx(a.purity.standard_error / 4, rel=0.3)
        assert abs(a.purity.value - b.purity.value) < 4 * a.purity.standard_error
        assert abs(a.recovery.value - b.recovery.value) < 4 * a.recovery.standard_error


def test_errors_of_shares_are_those_of_a_bootstrap() -> None:
    model = plant()
    result = played(model, 400)
    arrived = (result.confusion * right_bins(model)).sum(axis=2).astype(float)
    received = result.confusion.sum(axis=2).astype(float)
    rng = np.random.default_rng(0)
    drawn = rng.integers(400, size=(2000, 400))
    for b, found in enumerate(sorting_statistics(model, result).bins[:2]):
        shares = arrived[drawn, b].sum(axis=1) / received[drawn, b].sum(axis=1)
        assert found.purity.standard_error == pytest.approx(shares.std(), rel=0.1)


def test_one_batch_has_no_standard_errors() -> None:
    data = sorting_statistics(plant(), played(plant(), 1)).to_dict()
    assert data["right"]["standard_error"] is None
    assert data["confusion"]["standard_error"][0] == [None] * 4
    json.dumps(data, allow_nan=False)


def test_the_papers_bins_are_its_classes(paper: SortingModel) -> None:
    assert sorts_into_classes(paper)
    assert not sorts_into_classes(plant())
    assert not sorts_into_classes(random_model(0, reward=[[10, -5, -5], [-5, 10, -5], [-5, -7, 10]]))
    statistics = sorting_statistics(paper, played(paper))
    assert np.trace(statistics.confusion) == pytest.approx(statistics.right.value)


def test_compared_policies_have_their_bins_in_the_table() -> None:
    model = plant()
    policies = {"hasty": Threshold(model, 0.6), "careful": Threshold(model, 0.9)}
    compared = compare(model, policies, batches=30)
    statistics = sorting_statistics(model, evaluate(model, policies["hasty"], batches=30))
    assert compared.to_dict()["sorting"]["hasty"] == statistics.to_dict()
    assert f"metal: purity {statistics.bins[0].purity}" in " ".join(str(compared).split())
    plain = random_model(0)
    alike = {name: Threshold(plain, t) for name, t in (("a", 0.7), ("b", 0.8))}
    assert "purity" not in str(compare(plain, alike, batches=2))
