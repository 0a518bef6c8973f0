"""The number of modes is chosen by held-out objects."""

import json

import numpy as np
import pytest

from beltsort import ArgumentError
from beltsort.calibration.reliability import Pairs, reliability
from beltsort.perception import LabelRule
from beltsort.tables import LabelledScan, estimate
from beltsort.tables.held_out import STAGES, log_posteriors, predict, stratified_folds
from beltsort.tables.mode_choice import (
    NAMED,
    ONE_MODE,
    STICKY,
    ModeChoice,
    Score,
    candidates,
    choose_modes,
    fixed_modes,
)
from beltsort.tables.modes import ModeSettings, fit_modes
from beltsort.tables.repeated_looks import LooksAtObject, RepeatedLooks, TableShape, looks_at_objects
from beltsort.util.calibration_error import calibration_error
from tests.tables.planted import P_OBS, SHAPE, TRUTH, planted, planted_objects

FAST = ModeSettings(starts=3)


@pytest.fixture(scope="module")
def choice() -> ModeChoice:
    return choose_modes(planted(300, scans=2), most=3, settings=FAST)


def score(choice: ModeChoice, name: str) -> Score:
    return next(each for each in choice.scores if each.name == name)


def test_planted_modes_are_chosen(choice: ModeChoice) -> None:
    assert choice.name == "2 modes"
    assert choice.tables.kinds == 4
    assert score(choice, "2 modes").log_loss < score(choice, ONE_MODE).log_loss - 0.03
    assert score(choice, ONE_MODE).excess > 2.0 * score(choice, ONE_MODE).excess_error
    kinds = [each.kinds for each in choice.scores]
    assert kinds == sorted(kinds)
    assert min(each.excess for each in choice.scores) == 0.0
    assert "2 modes, 4 kinds (log-loss " in str(choice)
    assert [gain.doubled for gain in choice.gains] == ["objects", "looks at each object"]
    assert str(choice.gains[1]).startswith("Doubling the looks at each object has lowered the log-loss by ")


def test_the_choice_depends_on_nothing_but_its_seed(choice: ModeChoice) -> None:
    again = choose_modes(planted(300, scans=2), most=3, settings=FAST)
    assert again.scores == choice.scores
    assert str(again) == str(choice)


def test_one_mode_is_chosen_where_there_is_one() -> None:
    alike = P_OBS[:, :, [0, 0, 2, 2]]
    looks = RepeatedLooks.of(planted_objects(240, scans=1, p_obs=alike), SHAPE)
    chosen = choose_modes(looks, most=2, settings=FAST)
    assert chosen.name == ONE_MODE
    assert chosen.tables.kinds == 2
    assert "Warning" not in str(chosen)


def stuck_objects(number: int, seed: int = 1) -> RepeatedLooks:
    """Draw objects of two classes that return a label of their own, three in four that of their class."""
    rng = np.random.default_rng(seed)
    objects = []
    for n in range(number):
        own = n % 2 if rng.random() < 0.75 else 1 - n % 2
        looks = tuple((0, k, own if rng.random() < 0.95 else 1 - own) for k in (0, 1) for _ in range(3))
        objects.append(LooksAtObject(n % 2, looks))
    return RepeatedLooks.of(objects, TableShape(positions=1, viewpoints=2, classes=2, labels=2))


@pytest.mark.parametrize("seed", range(3))
def test_few_objects_whose_looks_repeat_do_not_have_one_mode(seed: int) -> None:
    chosen = choose_modes(stuck_objects(16, seed), most=2, folds=4, settings=FAST)
    assert chosen.repetition is not None
    assert chosen.repetition < 0.01
    assert chosen.name != ONE_MODE or score(chosen, ONE_MODE).excess == 0.0


def test_tables_that_say_nothing_of_other_objects_are_named() -> None:
    objects = [LooksAtObject(n % 2, ((0, 0, n // 2 % 2),) * 4) for n in range(16)]
    chosen = choose_modes(RepeatedLooks.of(objects, TableShape(1, 1, 2, 2)), most=2, folds=4, settings=FAST)
    assert chosen.unseen == pytest.approx(np.log(2.0))
    assert "Warning: without a look it is 0.693" in str(chosen)


@pytest.mark.parametrize(
    ("excess", "error", "as_good"), [(0.0, 0.0, True), (0.003, 0.0, True), (0.005, 0.0, False)]
)
def test_candidates_that_hardly_differ(excess: float, error: float, as_good: bool) -> None:
    assert Score("any", 4, 0.4 + excess, 0.05, 0.01, excess, error).is_as_good == as_good


def test_named_modes_are_a_candidate() -> None:
    chosen = choose_modes(planted(120, scans=2, named=True), most=2, settings=FAST)
    assert {each.name for each in chosen.scores} == {ONE_MODE, STICKY, "2 modes", NAMED}


def test_sticky_labels_of_more_kinds_than_planners_handle_are_no_candidate() -> None:
    """Twelve labels and three viewpoints: 1,728 kinds of each class."""
    objects = [LooksAtObject(n % 2, tuple((0, k, n % 12) for k in range(3))) for n in range(24)]
    looks = RepeatedLooks.of(objects, TableShape(1, 3, 2, 12))
    assert STICKY not in [each.name for each in candidates(looks, FAST, most=2)]
    assert STICKY in [each.name for each in candidates(planted(24, scans=2), FAST, most=2)]


@pytest.mark.parametrize("scans", [1, 2])
def test_too_few_looks_leave_one_mode_and_the_reason(scans: int) -> None:
    objects = [LooksAtObject(n % 2, ((0, 0, n % 3),) * scans) for n in range(40)]
    chosen = choose_modes(RepeatedLooks.of(objects, SHAPE))
    assert chosen.name == ONE_MODE
    assert str(chosen) == "One mode per class: fewer than two of its objects were looked at 3 times."
    assert (chosen.scores, chosen.gains) == ((), ())


def test_one_object_per_class_leaves_one_mode() -> None:
    objects = [LooksAtObject(n, ((0, 0, n), (0, 1, 2), (1, 0, n), (1, 1, n))) for n in range(2)]
    assert str(choose_modes(RepeatedLooks.of(objects, SHAPE))).startswith("One mode per class: 1 object")


def test_one_object_of_one_class_is_no_obstacle() -> None:
    objects = planted_objects(60, scans=2)
    looks = RepeatedLooks.of([each for n, each in enumerate(objects) if each.true == 0 or n == 1], SHAPE)
    chosen = choose_modes(looks, most=2, settings=FAST)
    assert chosen.reasons[0] is None
    assert chosen.reasons[1] is not None
    assert all(np.isfinite(each.log_loss) for each in chosen.scores)


def test_posteriors_are_calibrated_under_the_truth() -> None:
    looks = planted(4000, scans=1, seed=5)
    log_beliefs = log_posteriors(TRUTH, looks)
    beliefs = np.exp(log_beliefs)
    np.testing.assert_allclose(beliefs.sum(axis=1), 1.0)
    assert calibration_error(beliefs, looks.true) < 0.015
    overconfident = np.exp(log_posteriors(fit_modes(looks, modes=1), looks))
    assert calibration_error(overconfident, looks.true) > 0.03


def test_the_calibration_error_is_that_of_reliability() -> None:
    beliefs = np.random.default_rng(0).dirichlet(np.ones(3), size=200)
    true = np.random.default_rng(1).integers(3, size=200)
    pairs = Pairs(beliefs, np.arange(3) == true[:, None], np.arange(200), 200)
    assert calibration_error(beliefs, true) == pytest.approx(reliability(pairs).ece, rel=1e-12)


def test_a_prior_of_classes_counts() -> None:
    looks = planted(10, scans=1)
    even, uneven = log_posteriors(TRUTH, looks), log_posteriors(TRUTH, looks, arrival=[0.2, 0.8])
    odds = (uneven[:, 1] - uneven[:, 0]) - (even[:, 1] - even[:, 0])
    np.testing.assert_allclose(odds, np.log(4.0))


def test_predictions_get_better_with_looks() -> None:
    prediction = predict(TRUTH, planted(500, scans=2, seed=6))
    assert prediction.log_beliefs.shape == (500, len(STAGES), 2)
    right = prediction.log_beliefs[np.arange(500), :, prediction.true].mean(axis=0)
    assert (np.diff(right) > 0.0).all()
    assert prediction.losses.mean() == pytest.approx(-right.mean())


def test_folds_are_stratified() -> None:
    true = np.repeat([0, 1, 2], [11, 20, 4])
    folds = stratified_folds(true, 5, seed=0)
    sizes = np.array([[((folds == fold) & (true == c)).sum() for fold in range(5)] for c in range(3)])
    assert np.ptp(sizes, axis=1).max() <= 1
    assert np.ptp(sizes.sum(axis=0)) == 0


@pytest.mark.parametrize(("true", "folds"), [([0, 1], 1), ([0], 5)])
def test_folds_that_make_no_sense(true: list[int], folds: int) -> None:
    with pytest.raises(ArgumentError, match="folds, expected at least 2"):
        stratified_folds(true, folds, seed=0)


def scan_of(name: str, true: int, look: tuple[int, int, int | None]) -> LabelledScan:
    """A scan that shows one object."""
    position, viewpoint, label = look
    only = [j == position for j in range(SHAPE.positions)]
    return LabelledScan(
        viewpoint,
        tuple(true if here else None for here in only),
        tuple(name if here else None for here in only),
        tuple(label if here else None for here in only),
    )


def test_an_estimate_has_the_modes() -> None:
    objects = planted_objects(200, scans=2)
    scans = [scan_of(f"{n}", each.true, look) for n, each in enumerate(objects) for look in each.looks]
    looks = RepeatedLooks.of(looks_at_objects(scans), SHAPE)
    choice = fixed_modes(looks, 2, FAST)
    rule = LabelRule(("nut", "bolt"), not_recognised=True)
    result = estimate(scans, rule.classes, ["left", "right"], rule=rule, modes=choice.tables)
    np.testing.assert_allclose(result.model.p_obs, choice.tables.p_obs)
    np.testing.assert_allclose(result.model.modes, choice.tables.weights)
    assert result.counts.counts.shape == (2, 2, 2, 3)
    with pytest.raises(ArgumentError, match=r"repeats.*modes"):
        estimate(scans, rule.classes, ["left", "right"], rule=rule, modes=choice.tables, repeats=True)
    assert "2 modes" in str(choice)
    assert json.loads(json.dumps(choice.to_dict()))["chosen"] == "2 modes"
