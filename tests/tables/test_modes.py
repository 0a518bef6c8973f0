"""Tables with latent modes: what was planted is found, and one mode is the paper's tables."""

import numpy as np
import pytest

from beltsort import ArgumentError, Belief, SortingModel
from beltsort.tables import LabelledScan, count
from beltsort.tables.held_out import log_posteriors
from beltsort.tables.modes import ModeSettings, ModeTables, fit_modes, one_mode_reasons
from beltsort.tables.repeated_looks import LooksAtObject, RepeatedLooks, TableShape, looks_at_objects
from beltsort.tables.scans import looks as independent_looks
from tests.tables.planted import P_OBS, SHAPE, TRUTH, WEIGHTS, planted, planted_objects


@pytest.fixture(scope="module")
def fitted() -> ModeTables:
    return fit_modes(planted(1600, scans=2), modes=2)


def test_planted_modes_are_found(fitted: ModeTables) -> None:
    # The planted modes are ordered by weight, as fitted ones are.
    np.testing.assert_allclose(np.concatenate(fitted.weights), np.concatenate(WEIGHTS), atol=0.06)
    np.testing.assert_allclose(fitted.p_obs, P_OBS, atol=0.09)
    assert np.abs(fitted.p_obs - P_OBS).mean() < 0.025
    assert fitted.objects.sum() == pytest.approx(1600)


def test_intervals_are_about_right(fitted: ModeTables) -> None:
    lower, upper = fitted.intervals()
    assert ((lower <= fitted.p_obs) & (fitted.p_obs <= upper)).all()
    assert ((lower <= P_OBS) & (upper >= P_OBS)).mean() > 0.75  # they take the objects' modes as known
    assert (upper - lower).max() < 0.2


def test_the_fit_explains_unseen_looks_as_well_as_the_truth(fitted: ModeTables) -> None:
    test = planted(1000, scans=2, seed=1)
    rows = np.arange(len(test))
    own, best = (tables.log_likelihoods(test)[rows, test.true].mean() for tables in (fitted, TRUTH))
    without = fit_modes(planted(1600, scans=2), modes=1).log_likelihoods(test)[rows, test.true].mean()
    assert best - 0.03 < own < best + 0.03
    assert without < own - 0.2


def test_one_mode_is_the_smoothed_table() -> None:
    rng = np.random.default_rng(2)
    scans = [
        LabelledScan(k, (n % 3, None), (f"{n}", None), (int(rng.integers(3)), None))
        for n in range(60)
        for k in (0, 1, 0, 1, 1)
    ]
    counts = count(independent_looks(scans), positions=2, viewpoints=2, classes=3)
    looks = RepeatedLooks.of(looks_at_objects(scans), TableShape(2, 2, 3, 3))
    tables = fit_modes(looks, 1, ModeSettings(smoothing=0.5))
    np.testing.assert_allclose(tables.p_obs, counts.probabilities(0.5), atol=1e-12, rtol=0.0)
    assert tables.weights == ((1.0,),) * 3


def test_the_order_of_objects_and_looks_does_not_matter() -> None:
    looks = planted(80, scans=2)
    first = fit_modes(looks, modes=3)
    second = fit_modes(looks.shuffled(3).of_objects(np.random.default_rng(0).permutation(80)), modes=3)
    assert first.class_of.tolist() == second.class_of.tolist()
    np.testing.assert_allclose(first.p_obs, second.p_obs, atol=1e-6)
    np.testing.assert_allclose(np.concatenate(first.weights), np.concatenate(second.weights), atol=1e-6)


def test_relabelled_classes_have_the_same_modes_up_to_the_starts() -> None:
    objects = planted_objects(600, scans=2)
    swapped = [LooksAtObject(1 - each.true, each.looks) for each in objects]
    first, second = (fit_modes(RepeatedLooks.of(each, SHAPE), modes=2) for each in (objects, swapped))
    np.testing.assert_allclose(first.p_obs, second.p_obs[:, :, [2, 3, 0, 1]], atol=1e-3)


def test_likelihood_is_the_sum_over_modes(fitted: ModeTables) -> None:
    looks = ((0, 1, 2), (1, 0, 0), (0, 1, 2), (1, 1, None))
    one = RepeatedLooks.of([LooksAtObject(1, looks)], SHAPE)
    for label in range(2):
        expected = sum(
            weight * np.prod([fitted.p_obs[j, k, 2 * label + m, z] for j, k, z in looks if z is not None])
            for m, weight in enumerate(fitted.weights[label])
        )
        assert fitted.log_likelihoods(one)[0, label] == pytest.approx(np.log(expected), rel=1e-12)
    posterior = fitted.mode_posteriors(one)[0]
    assert posterior[:2].tolist() == [0.0, 0.0]
    assert posterior.sum() == pytest.approx(1.0)


def test_a_belief_of_the_core_is_the_posterior(fitted: ModeTables) -> None:
    names = ["0", "1", "nothing"]
    model = SortingModel(["0", "1"], ["low", "high"], fitted.p_obs, labels=names, modes=fitted.weights)
    looks = ((0, 1, 2), (0, 0, 0), (0, 1, 2), (0, 1, 1))
    belief = Belief(model)
    for _, k, z in looks:
        belief.observe(k, [z, None])
    expected = np.exp(log_posteriors(fitted, RepeatedLooks.of([LooksAtObject(0, looks)], SHAPE)))
    np.testing.assert_allclose(belief.probabilities[0], expected[0], rtol=1e-9)


def test_empty_modes_are_dropped() -> None:
    alike = [LooksAtObject(n % 2, ((0, 0, n % 2), (0, 1, 2), (1, 0, 0), (1, 1, 1))) for n in range(6)]
    tables = fit_modes(RepeatedLooks.of(alike, SHAPE), modes=8)
    assert tables.kinds < 8
    assert (tables.objects >= 1.0 - 1e-6).all()
    assert [sum(weights) for weights in tables.weights] == pytest.approx([1.0, 1.0])


def test_named_modes_are_counted_not_guessed() -> None:
    objects = planted_objects(60, scans=1, named=True)
    tables = fit_modes(RepeatedLooks.of(objects, SHAPE), modes=2)
    assert tables.names == (("mode 0", "mode 1"),) * 2
    for kind, (label, name) in enumerate([(0, "mode 0"), (0, "mode 1"), (1, "mode 0"), (1, "mode 1")]):
        assert tables.objects[kind] == sum((each.true, each.mode) == (label, name) for each in objects)


def test_objects_of_unknown_mode_join_the_named_ones() -> None:
    objects = planted_objects(400, scans=3, named=True)
    few = [each if n < 20 else LooksAtObject(each.true, each.looks) for n, each in enumerate(objects)]
    tables = fit_modes(RepeatedLooks.of(few, SHAPE), modes=2)
    assert tables.names == (("mode 0", "mode 1"),) * 2
    np.testing.assert_allclose(tables.p_obs, P_OBS, atol=0.17)


def test_modes_that_cannot_be_told_apart() -> None:
    long = ((0, 0, 0), (0, 0, 1), (0, 1, 1))
    objects = [LooksAtObject(0, long), LooksAtObject(1, long), LooksAtObject(1, long[:2])]
    looks = RepeatedLooks.of(objects, SHAPE)
    alone, few = one_mode_reasons(looks)
    assert alone is not None
    assert alone.startswith("1 object of the class")
    assert few == "fewer than two of its objects were looked at 3 times"
    assert fit_modes(looks, modes=4).weights == ((1.0,), (1.0,))
    more = RepeatedLooks.of([*objects, LooksAtObject(1, long)], SHAPE)
    assert one_mode_reasons(more)[1] is None


def test_a_class_without_objects_is_the_prior_alone() -> None:
    looks = RepeatedLooks.of([each for each in planted_objects(40, scans=2) if each.true == 0], SHAPE)
    tables = fit_modes(looks, modes=2)
    assert len(tables.weights[1]) == 1
    np.testing.assert_allclose(tables.p_obs[:, :, -1], 1 / 3)


def test_more_pseudo_looks_pull_modes_together() -> None:
    looks = planted(200, scans=2)
    spread = []
    for number in (1.0, 100.0, 1e6):
        tables = fit_modes(looks, 2, ModeSettings(pseudo_looks=number, position_looks=number))
        spread.append(float(np.ptp(tables.p_obs[:, :, :2], axis=2).max()) if tables.kinds == 4 else 0.0)
    assert spread[0] > spread[1] > spread[2] or spread[1] == spread[2] == 0.0
    assert spread[2] < 0.01


@pytest.mark.parametrize(
    "wrong", [{"smoothing": 0.0}, {"pseudo_looks": -1.0}, {"position_looks": np.nan}, {"starts": 0}]
)
def test_settings_out_of_range(wrong: dict[str, float]) -> None:
    with pytest.raises(ArgumentError, match="expected"):
        ModeSettings(**wrong)  # type: ignore[arg-type]  # the values are numbers of either type


def test_no_modes() -> None:
    with pytest.raises(ArgumentError, match="modes is 0"):
        fit_modes(planted(4, scans=1), modes=0)
