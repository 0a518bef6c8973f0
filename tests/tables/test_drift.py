"""The watch is silent while the model is right, and speaks up when it is not."""

import re
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from beltsort import ArgumentError, Belief, SortingModel
from beltsort.tables import Alarm, DriftWatch
from tests.cli.running import PAPER
from tests.sorting.plant import plant

SURE = 0.94  # the belief at which objects are decided


def smoothed() -> SortingModel:
    """The paper's model with tables as if from fifty objects in each row: nothing is impossible."""
    paper = SortingModel.load(PAPER)
    return SortingModel(paper.classes, paper.viewpoints, (50 * paper.p_obs + 1) / (50 + 4))


MODEL = smoothed()


def scans_until_alarm(watch: DriftWatch, seed: int, tables: Sequence[NDArray[np.float64]]) -> int:
    """Look from random viewpoints, the n-th time with the n-th table; return when there is an alarm."""
    rng = np.random.default_rng(seed)
    belief = Belief(MODEL)
    true = [int(label) for label in rng.integers(4, size=2)]
    for scan, p_obs in enumerate(tables):
        viewpoint = int(rng.integers(3))
        chance = rng.random(2)
        labels = [
            int(np.searchsorted(np.cumsum(p_obs[j, viewpoint, true[j]])[:-1], chance[j])) for j in range(2)
        ]
        if watch.observe(belief, viewpoint, labels):
            return scan
        belief.observe(viewpoint, labels)
        if belief.most_likely(0)[1] >= SURE:
            belief.advance()
            true = [true[1], int(rng.integers(4))]
    return len(tables)


@pytest.mark.slow
def test_false_alarms_are_as_rare_as_promised() -> None:
    scans, runs = 300, 100
    silent = [
        scans_until_alarm(DriftWatch(MODEL, false_alarm=0.2), seed, [MODEL.p_obs] * scans) == scans
        for seed in range(runs)
    ]
    assert runs - sum(silent) <= 32  # more at a rate of 0.2 with probability 0.002


def test_a_moved_camera_is_noticed_where_it_is() -> None:
    changed = MODEL.p_obs.copy()
    changed[:, 2] = np.roll(changed[:, 2], 1, axis=-1)
    delays, there = [], 0
    for seed in range(10):
        watch = DriftWatch(MODEL, false_alarm=0.05)
        delays.append(scans_until_alarm(watch, seed, [MODEL.p_obs] * 200 + [changed] * 600) - 200)
        there += watch.alarms[0].viewpoint in (2, None)
    assert min(delays) > 0
    assert there >= 8
    assert np.median(delays) < 200


def test_a_new_batch_is_noticed_by_all_gamblers_together() -> None:
    changed = 0.7 * MODEL.p_obs + 0.3 / 4
    delays, everywhere = [], 0
    for seed in range(10):
        watch = DriftWatch(MODEL, false_alarm=0.05)
        delays.append(scans_until_alarm(watch, seed, [MODEL.p_obs] * 200 + [changed] * 800) - 200)
        everywhere += any(alarm.viewpoint is None for alarm in watch.alarms)
    assert np.median(delays) < 400
    assert everywhere >= 5


def test_a_classifier_that_is_wrong_but_sure_is_noticed() -> None:
    sure = np.broadcast_to(np.eye(4)[[1, 1, 3, 3]], MODEL.p_obs.shape)  # it never contradicts itself
    delays = [
        scans_until_alarm(DriftWatch(MODEL, false_alarm=0.05), seed, [MODEL.p_obs] * 200 + [sure] * 600) - 200
        for seed in range(10)
    ]
    assert min(delays) > 0
    assert np.median(delays) < 100


def test_the_evidence_is_a_martingale() -> None:
    table = np.array([[[[0.7, 0.3], [0.4, 0.6]]]])
    model = SortingModel(["nut", "bolt"], ["above"], table, arrival=[0.3, 0.7])
    mean = 0.0  # of the evidence after six looks, over all their possible labels
    for labels in np.ndindex(*[2] * 6):
        watch, belief, probability = DriftWatch(model, false_alarm=1e-9), Belief(model), 1.0
        for label in labels:
            probability *= belief.label_probabilities(0)[0, label]
            watch.observe(belief, 0, [label])
            belief.observe(0, [label])
        test = watch._tests[0, 0]
        mean += probability * (test.at_stake.mean() + 1.0 / (test.looks + 1))
    assert mean == pytest.approx(1.0, abs=1e-12)


def test_surprise_is_standardised_while_the_model_is_right() -> None:
    scores = []
    for seed in range(40):
        watch = DriftWatch(MODEL)
        scans_until_alarm(watch, seed, [MODEL.p_obs] * 100)
        mean, error = watch.surprise()
        scores.append(mean / error)
    np.testing.assert_allclose(np.mean(scores), 0.0, atol=0.26)  # 4 / sqrt(240)
    np.testing.assert_allclose(np.std(scores), 1.0, atol=0.2)


def test_surprise_is_what_the_labels_lack() -> None:
    model = SortingModel(["nut", "bolt"], ["above"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    watch, sure = DriftWatch(model), Belief(model, [[1.0, 0.0]])
    assert np.isnan(watch.surprise()[0]).all()
    for label in (0, 1):
        watch.observe(sure, 0, [label])
    entropy = -0.8 * np.log(0.8) - 0.2 * np.log(0.2)
    mean, error = watch.surprise()
    assert mean.item() == pytest.approx((-np.log(0.8) - np.log(0.2)) / 2 - entropy)
    assert error.item() == pytest.approx(np.sqrt(0.16 * np.log(4) ** 2 / 2))


def test_labels_that_are_missing_tell_nothing() -> None:
    watch = DriftWatch(MODEL)
    assert watch.observe(Belief(MODEL), 0, [None, None]) == []
    assert np.isnan(watch.surprise()[0]).all()


def test_an_impossible_label_alarms_at_once_and_once() -> None:
    paper = SortingModel.load(PAPER)
    watch, sure = DriftWatch(paper), Belief(paper, [[1.0, 0.0, 0.0, 0.0]] * 2)
    raised = watch.observe(sure, 0, [2, None])
    assert raised == [Alarm(0, 0, 1, np.inf), Alarm(None, None, 1, np.inf)] == watch.alarms
    assert [alarm.to_dict()["evidence"] for alarm in raised] == [None, None]
    assert watch.observe(sure, 0, [2, None]) == []
    assert len(watch.alarms) == 2


def test_a_repeat_that_the_model_knows_is_no_drift() -> None:
    model = SortingModel(MODEL.classes, MODEL.viewpoints, MODEL.p_obs, repeat=0.9)
    watch, belief = DriftWatch(model), Belief(model)
    for _ in range(50):
        assert watch.observe(belief, 0, [1, 1]) == []
        belief.observe(0, [1, 1])


@pytest.mark.parametrize("false_alarm", [0.0, 1.0, -0.1, float("nan")])
def test_the_rate_is_a_probability(false_alarm: float) -> None:
    with pytest.raises(ArgumentError, match=rf"false_alarm\b.*{false_alarm}\b.*\b0\.01\b"):
        DriftWatch(MODEL, false_alarm=false_alarm)


def test_what_does_not_fit_is_refused() -> None:
    watch = DriftWatch(MODEL)
    with pytest.raises(ArgumentError, match=r"\bbelief\b.*\bmodel\b"):
        watch.observe(Belief(MODEL.with_positions(1)), 0, [0])
    for labels in ([0], [0, 4], [0, -1]):
        with pytest.raises(ArgumentError, match=rf"labels\b.*{re.escape(str(labels))}.*\b2\b.*\b0\b.*\b3\b"):
            watch.observe(Belief(MODEL), 0, labels)
    with pytest.raises(ArgumentError, match=r"viewpoint 3\b.*\bp1, p2, p3\b"):
        watch.observe(Belief(MODEL), 3, [0, 0])


def test_labels_need_not_be_the_classes() -> None:
    model, rng = plant(), np.random.default_rng(3)
    watch, belief = DriftWatch(model, false_alarm=0.01), Belief(model)
    for _ in range(200):
        predicted = belief.label_probabilities(1)
        watch.observe(belief, 1, [int(rng.choice(12, p=row / row.sum())) for row in predicted])
    assert watch.alarms == []
    again = DriftWatch.of_state(model, watch.state())
    while not watch.alarms:
        watch.observe(belief, 1, [11, 11])
        again.observe(belief, 1, [11, 11])
    assert again.alarms == watch.alarms
    with pytest.raises(ArgumentError, match=r"\b12\b.*\b0 to 11\b"):
        watch.observe(belief, 1, [12, 0])
