"""Reliability of synthetic beliefs, and of what a journal tells."""

import numpy as np
import pytest

import beltsort
from beltsort.calibration.check import Arm
from beltsort.calibration.dependence import ObjectLooks, dependences
from beltsort.calibration.promise import promises
from beltsort.calibration.reliability import Pairs, reliability
from beltsort.calibration.simulated_runs import simulate_runs
from beltsort.calibration.sorted_runs import SortedRun, run_in
from beltsort.models import simulated
from beltsort.perception import rule_of
from beltsort.planning.decisions import right_bins
from beltsort.sim import CellConfig
from beltsort.sorting.entries import AnyContent, Decided, Scanned, Started
from beltsort.sorting.journal import Entry
from tests.sorting.plant import plant


def pairs(n: int, temper: float) -> Pairs:
    rng = np.random.default_rng(1)
    beliefs = rng.dirichlet([0.5] * 3, n)
    truth = beliefs**temper / (beliefs**temper).sum(axis=1, keepdims=True)
    drawn = (rng.random((n, 1)) > truth.cumsum(axis=1)).sum(axis=1).clip(max=2)
    return Pairs(beliefs, np.arange(3) == drawn[:, np.newaxis], np.arange(n), n)


def test_calibrated_beliefs_err_by_chance_alone() -> None:
    curve = reliability(pairs(1000, temper=1.0))
    assert curve.ece < 1.6 * curve.ece_chance
    assert abs(curve.brier - curve.brier_expected) < 3.0 * curve.brier_excess_error
    assert curve.counts.sum() == curve.pairs == 3000


def test_overconfident_beliefs_are_found() -> None:
    curve = reliability(pairs(1000, temper=0.4))
    assert curve.ece > 3.0 * curve.ece_chance
    assert curve.ece_p < 0.01
    assert curve.brier > curve.brier_expected + 3.0 * curve.brier_excess_error


def test_bad_pairs_are_refused() -> None:
    with pytest.raises(beltsort.ArgumentError, match="shapes"):
        Pairs([[0.5]], [[True, False]], [0], 1)
    with pytest.raises(beltsort.ArgumentError, match="probability"):
        Pairs([[1.5]], [[True]], [0], 1)


def test_only_repeated_looks_depend() -> None:
    rng = np.random.default_rng(0)
    true = np.arange(400) % 2
    labels = np.where(
        rng.random((400, 2, 2, 1)) < 0.7, true[:, None, None, None], 1 - true[:, None, None, None]
    )
    repeat, *others = dependences(ObjectLooks(true, np.repeat(labels, 2, axis=3)))
    assert repeat.repeated == pytest.approx(1.0)
    assert all(abs(found.repeated) < 4.0 * found.repeated_error for found in others)


def test_pairs_of_a_run_are_its_journal() -> None:
    model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]] * 2)
    belief = [[0.8, 0.2], [0.2, 0.8]]
    contents: list[tuple[int | None, AnyContent]] = [
        (None, Started(run="r", objects=1, model=model.to_json())),
        (0, Scanned(0, [0, 1], [False, False], ["object", "object"], [], belief, [[-1], [-1]])),
        (0, Decided(label=0, bin=0, belief=0.8, looks=1, forced=None)),
    ]
    entries = [Entry(number, "", index, told) for number, (index, told) in enumerate(contents, start=1)]
    run = run_in(entries, true=[0])
    assert run.beliefs == ((0, (0.8, 0.2)),)
    assert run.decisions == ((0, 0, 0.8),)
    assert run.correct == 1


def test_a_decision_is_believed_as_its_bin_is_right() -> None:
    model = plant()
    runs = simulate_runs(model, objects=200, seed=1, workers=1)
    counts = np.sum([run.confusion for run in runs], axis=0)
    assert counts.shape == (4, 6)
    assert counts.sum() == 200
    right = sum(run.correct for run in runs)
    assert right == counts[right_bins(model)].sum() > 100
    believed = [belief for run in runs for *_, belief in run.decisions]
    spread = np.sqrt(sum(belief * (1.0 - belief) for belief in believed))
    assert abs(sum(believed) - right) < 4.0 * spread
    arm = Arm.of(runs)
    assert arm.to_dict()["confusion"] == counts.tolist()
    assert arm.curves["decisions"].pairs == 200


def test_an_object_in_the_reject_bin_is_not_right() -> None:
    model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    run = SortedRun.of(model, [0, 1], 4, [(0, None, 0.6), (1, 1, 0.9)], [])
    assert (run.right, run.correct, run.confusion) == ((False, True), 1, ((0, 0), (0, 1)))


def test_a_promise_is_kept_where_the_tables_are_true_and_not_where_looks_repeat() -> None:
    model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]] * 2)
    runs = {
        "true": simulate_runs(model, objects=300, seed=1, workers=1),
        "repeating": simulate_runs(
            model, objects=300, seed=1, truth=model.replace(repeat=[[0.9]] * 2), workers=1
        ),
    }
    arms = {name: Arm.of(sorted_runs) for name, sorted_runs in runs.items()}
    found = promises(dict.fromkeys(arms, model), arms, objects=300, seed=2, workers=1)
    lower, upper = found["true"].interval
    assert lower < 0.0 < upper
    assert found["repeating"].interval[1] < -0.1
    assert found["true"].promised == found["repeating"].promised
    assert found["true"].to_dict()["right"] == pytest.approx(10 * arms["true"].right.mean())


def test_the_packaged_model_with_modes_is_of_the_default_cell() -> None:
    model, config = simulated(), CellConfig()
    assert tuple(model.classes) == config.classes
    assert model.viewpoints == [viewpoint.name for viewpoint in config.viewpoints]
    assert model.positions == config.layout.positions
    assert rule_of(model).levels > 1
    assert "beltsort estimate simulated" in model.note
