"""Bad input is one exception under BeltsortError, which names what is wrong and the values."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    Belief,
    Decide,
    Despot,
    ImpossibleObservationError,
    InformationGain,
    LookAhead,
    ModelError,
    Move,
    OneObject,
    PolicyError,
    SortingModel,
    Threshold,
    compare,
    evaluate,
    solve,
)

from .bad_input import TABLES, Case, check_refused, file, model
from .models import beyond_model, random_model
from .policies import Always

MODEL = random_model(0)
OTHER = random_model(1)
BEYOND = beyond_model(0)
REPEATING = random_model(0, repeat=0.5)
THRESHOLD = Threshold(MODEL, 0.9)
PLAN = Despot(MODEL, trials=1).plan(Belief(MODEL))


def evaluation(**settings: Any) -> Callable[[], object]:
    return lambda: evaluate(MODEL, THRESHOLD, **{"batches": 2, **settings})


def despot(**settings: Any) -> Callable[[], object]:
    return lambda: Despot(MODEL, **settings)


def plan(*arguments: Any, **settings: Any) -> Callable[[], object]:
    return lambda: Despot(MODEL, trials=1).plan(Belief(MODEL), *arguments, **settings)


def observe(viewpoint: int, labels: list[Any]) -> Callable[[], object]:
    return lambda: Belief(MODEL).observe(viewpoint, labels)


CASES: dict[str, Case] = {
    "row sum": (
        model([[[[0.5, 0.6], [0.1, 0.9]]]]),
        ModelError,
        ["p_obs[0][0][0]", "[0.5, 0.6]", "1.1", "1"],
    ),
    "negative entry": (model([[[[-0.5, 1.5], [0.1, 0.9]]]]), ModelError, ["p_obs[0][0][0]", "-0.5"]),
    "NaN entry": (model([[[[np.nan, 0.5], [0.1, 0.9]]]]), ModelError, ["p_obs[0][0][0]", "NaN"]),
    "axes": (model([[0.5, 0.5], [0.1, 0.9]]), ModelError, ["p_obs", "[2, 2]", "(H, K, L, L)"]),
    "viewpoints in p_obs": (
        model(TABLES, viewpoints=["v", "w"]),
        ModelError,
        ["p_obs[0]", "1", "2", "viewpoint"],
    ),
    "classes in p_obs": (
        model(TABLES, classes=["a", "b", "c"]),
        ModelError,
        ["p_obs[0][0]", "2", "3", "class"],
    ),
    "no positions": (model(np.zeros((0, 1, 2, 2))), ModelError, ["p_obs", "position", "(H, K, L, L)", "1"]),
    "ragged p_obs": (
        model([[[[0.5, 0.5], [1.0]]]]),
        ModelError,
        ["p_obs[0][0][1]", "1 entries", "expected 2"],
    ),
    "p_obs of words": (model("tables"), ModelError, ["p_obs", "tables"]),
    "one class": (model([[[[1.0]]]], classes=["a"]), ModelError, ["classes", "1", "2"]),
    "same name": (model(classes=["a", "a"]), ModelError, ["classes", '"a"']),
    "discount 1": (model(discount=1.0), ModelError, ["discount", "1", "0", "0.95"]),
    "discount 0": (model(discount=0.0), ModelError, ["discount", "0", "1", "0.95"]),
    "r_min 0": (model(r_min=0.0), ModelError, ["r_min", "0"]),
    "r_min negative": (model(r_min=-50.0), ModelError, ["r_min", "-50", "0"]),
    "r_max infinite": (model(r_max=np.inf), ModelError, ["r_max", "inf"]),
    "arrival length": (
        model(arrival=[1.0]),
        ModelError,
        ["arrival", "1", "2"],
    ),
    "arrival sum": (model(arrival=[0.5, 0.4]), ModelError, ["arrival", "[0.5, 0.4]", "0.9", "1"]),
    "motion cost shape": (
        model(motion_cost=[[1.0, 1.0]]),
        ModelError,
        ["motion_cost[0]", "2", "1", "viewpoint"],
    ),
    "motion cost ragged": (model(motion_cost=[[1.0], []]), ModelError, ["motion_cost", "inhomogeneous"]),
    "motion cost negative": (model(motion_cost=-1.0), ModelError, ["motion_cost", "-1", "travel"]),
    "travel too far": (model(travel=[[1]]), ModelError, ["travel[0]", "viewpoint", "1", "0"]),
    "travel negative": (model(travel=[[-1]]), ModelError, ["travel", "viewpoint", "-1", "0"]),
    "travel length": (model(travel=[]), ModelError, ["travel", "0", "1", "viewpoint"]),
    "counts shape": (model(counts=[[[[1, 2]]]]), ModelError, ["counts", "p_obs", "(H, K, L, L)"]),
    "counts negative": (model(counts=[[[[-1, 2], [3, 4]]]]), ModelError, ["counts", "-1"]),
    "counts broken": (model(counts=[[[[0.5, 2], [3, 4]]]]), ModelError, ["counts", "0.5"]),
    "smoothing": (model(smoothing=-1.0), ModelError, ["smoothing", "-1"]),
    "smoothing of an entry": (model(smoothing=[[[[1.0, 1.0], [-1.0, 1.0]]]]), ModelError, ["smoothing = -1"]),
    "smoothing shape": (
        model(smoothing=[[[[1.0, 1.0]]]]),
        ModelError,
        ["smoothing", "(H, K, L, L)", "number"],
    ),
    "smoothing word": (model(smoothing="high"), ModelError, ["smoothing"]),
    "repeat 1": (model(repeat=1.0), ModelError, ["repeat", "1", "0"]),
    "repeat negative": (model(repeat=-0.1), ModelError, ["repeat", "-0.1", "0", "1"]),
    "repeat NaN": (model(repeat=[[np.nan]]), ModelError, ["repeat", "NaN", "0", "1"]),
    "repeat positions": (model(repeat=[[0.5], [0.5]]), ModelError, ["repeat", "2", "1", "position"]),
    "repeat viewpoints": (
        model(repeat=[[0.5, 0.5]]),
        ModelError,
        ["repeat[0]", "2", "1", "viewpoint"],
    ),
    "information gain": (model(information_gain=-1.0), ModelError, ["information_gain", "-1", "0"]),
    "infinite gain": (model(information_gain=np.inf), ModelError, ["information_gain", "inf", "0"]),
    "empty class": (model(empty="c"), ModelError, ["empty", '"c"', "(a, b)"]),
    "belief of kinds": (
        lambda: Belief(BEYOND, [[0.5, 0.5]] * 2),
        ArgumentError,
        ["probabilities", "2", "(2, 3)", "(2, 4)"],
    ),
    "label beyond the labels": (
        lambda: Belief(BEYOND).observe(0, [2, None]),
        ArgumentError,
        ["label", "2", "seen, sure", "seen"],
    ),
    "bin of a policy": (
        lambda: evaluate(BEYOND, Always(Decide(2)), batches=1),
        PolicyError,
        ["decisions below 2"],
    ),
    "solve repeats": (lambda: solve(REPEATING), ModelError, ["solve", "repeat", "Threshold"]),
    "solve scans after decisions": (
        lambda: solve(random_model(0, observe_after_decision=True)),
        ModelError,
        ["solve", "observe_after_decision", "Threshold"],
    ),
    "solve bonuses": (
        lambda: solve(random_model(0, information_gain=0.1)),
        ModelError,
        ["solve", "information_gain", "Threshold"],
    ),
    "last labels' shape": (
        lambda: Belief(REPEATING, last_labels=[[0, 1]]),
        ArgumentError,
        ["last_labels", "1", "[2]", "(2, 2)"],
    ),
    "last label": (
        lambda: Belief(REPEATING, last_labels=[[0, 3], [0, 0]]),
        ArgumentError,
        ["label", "3", "c0, c1, c2"],
    ),
    "negative last label": (
        lambda: Belief(REPEATING, last_labels=[[0, -2], [0, 0]]),
        ArgumentError,
        ["last_labels", "-2"],
    ),
    "objects left": (lambda: Belief(MODEL, remaining=-1), ArgumentError, ["remaining", "-1", "0", "None"]),
    "nothing left": (
        lambda: Despot(MODEL, trials=1).plan(Belief(MODEL, remaining=0), 0),
        ArgumentError,
        ["remaining", "0"],
    ),
    "regret where the belt ends": (
        lambda: evaluate(MODEL, OneObject(MODEL), reference=solve(MODEL, seconds=0.2), belt_ends=True),
        ArgumentError,
        ["reference", "belt_ends"],
    ),
    "unknown key": (
        file(p_obs=TABLES, discont=0.9),
        ModelError,
        ['"discont"', '"discount"', "classes, viewpoints, p_obs"],
    ),
    "missing key": (file(), ModelError, ["missing", "`p_obs`"]),
    "wrong type": (file(p_obs=TABLES, r_min="high"), ModelError, ["r_min", '"high"', "a number"]),
    "classes no list": (file(p_obs=TABLES, classes=3), ModelError, ["classes is 3", "a list of names"]),
    "entry of p_obs": (
        file(p_obs=[[[[0.8, 0.2], [0.2, "x"]]]]),
        ModelError,
        ['p_obs[0][0][1][1] is "x"', "four nested lists"],
    ),
    "ragged p_obs of a file": (
        file(p_obs=[[[[0.8, 0.2], [1.0]]]]),
        ModelError,
        ["p_obs[0][0][1]", "1 entries", "expected 2"],
    ),
    "viewpoint in travel": (
        file(p_obs=TABLES, travel=[["front"]]),
        ModelError,
        ['travel[0][0] is "front"', "numbers"],
    ),
    "classes in one word": (model(classes="ab"), ModelError, ["classes is 'ab'", "a list of names"]),
    "list for a number": (model(r_min=[1, 2]), ModelError, ["r_min is [1, 2]", "a number"]),
    "replaced by a list": (lambda: MODEL.replace(r_max=[1]), ModelError, ["r_max is [1]", "a number"]),
    "class of a policy": (
        lambda: evaluate(MODEL, OneObject),  # type: ignore[arg-type]  # which is the mistake
        PolicyError,
        ["policy is the class OneObject", "OneObject(model)"],
    ),
    "list of policies": (
        lambda: compare(MODEL, [THRESHOLD]),  # type: ignore[arg-type]  # which is the mistake
        ArgumentError,
        ["policies is a list", "a dict of policies by name"],
    ),
    "no JSON": (lambda: SortingModel.from_json("{"), ModelError, ["JSON", "line 1 column 1"]),
    "no object": (
        lambda: SortingModel.from_json("[]"),
        ModelError,
        ["JSON", "object", "classes", "viewpoints", "p_obs"],
    ),
    "no file": (lambda: SortingModel.load("absent.json"), ModelError, ["absent.json", "No such file"]),
    "no folder": (lambda: MODEL.save("absent/m.json"), ModelError, ["absent/m.json", "No such file"]),
    "no positions left": (lambda: MODEL.with_positions(0), ArgumentError, ["positions", "0", "2", "1"]),
    "positions to keep": (lambda: MODEL.with_positions(-2), ArgumentError, ["positions", "-2", "1"]),
    "label": (observe(0, [3, None]), ArgumentError, ["label", "3", "0", "2", "c0, c1, c2"]),
    "negative label": (observe(0, [-1, None]), ArgumentError, ["label", "-1", "0"]),
    "labels": (observe(0, [1]), ArgumentError, ["1", "2", "label", "position"]),
    "viewpoint of a scan": (observe(2, [0, 0]), ArgumentError, ["viewpoint", "2", "0", "1", "v0, v1"]),
    "negative viewpoint": (observe(-1, [0, 0]), ArgumentError, ["viewpoint", "-1", "0"]),
    "impossible label": (
        lambda: Belief(SortingModel(["a", "b"], ["v"], [[[[1, 0], [1, 0]]]])).observe(0, [1]),
        ImpossibleObservationError,
        ["position 1", "viewpoint", "v", "label", "b"],
    ),
    "belief shape": (
        lambda: Belief(MODEL, [[0.5, 0.5]]),
        ArgumentError,
        ["probabilities", "1", "[2]", "(2, 3)"],
    ),
    "belief axes": (lambda: Belief(MODEL, [0.5, 0.5]), ArgumentError, ["probabilities", "[2]", "two"]),
    "belief sum": (
        lambda: Belief(MODEL, [[1, 1, 0], [1, 0, 0]]),
        ArgumentError,
        ["probabilities[0]", "[1.0, 1.0, 0.0]", "2", "1"],
    ),
    "position": (lambda: Belief(MODEL).most_likely(2), ArgumentError, ["position", "2", "0", "1"]),
    "planned viewpoint": (plan(2), ArgumentError, ["viewpoint", "2", "v0, v1"]),
    "negative planned viewpoint": (plan(-1), ArgumentError, ["viewpoint", "-1", "0"]),
    "belief of another model": (
        lambda: Despot(MODEL, trials=1).plan(Belief(OTHER)),
        ArgumentError,
        ["belief", "Belief(policy.model)"],
    ),
    "belief of another model, policy": (
        lambda: THRESHOLD.act(Belief(OTHER), 0),
        ArgumentError,
        ["belief", "Belief(policy.model)"],
    ),
    "trials 0": (plan(trials=0), ArgumentError, ["trials", "0", "1", "100"]),
    "trials negative": (despot(trials=-3), ArgumentError, ["trials", "-3", "1"]),
    "seconds 0": (plan(seconds=0.0), ArgumentError, ["seconds", "0", "0.01"]),
    "seconds negative": (despot(seconds=-1.0), ArgumentError, ["seconds", "-1", "0", "0.01"]),
    "seconds NaN": (despot(seconds=np.nan), ArgumentError, ["seconds", "NaN", "0"]),
    "both budgets": (plan(seconds=1.0, trials=1), ArgumentError, ["seconds", "trials", "both"]),
    "both budgets at once": (despot(seconds=1.0, trials=1), ArgumentError, ["seconds", "trials", "both"]),
    "scenarios 0": (despot(scenarios=0), ArgumentError, ["scenarios", "0", "1", "1000000", "500"]),
    "scenarios negative": (despot(scenarios=-1), ArgumentError, ["scenarios", "-1", "1"]),
    "depth 0": (despot(depth=0), ArgumentError, ["depth", "0", "1", "1000"]),
    "regularization": (despot(regularization=-0.1), ArgumentError, ["regularization", "-0.1"]),
    "regularised beliefs": (
        despot(regularization=0.1),
        ArgumentError,
        ["regularization", "0.1", "as published"],
    ),
    "variant": (despot(variant="belief"), ArgumentError, ["variant", "belief", "beliefs", "scenarios"]),
    "look-ahead depth": (lambda: LookAhead(MODEL, 5), ArgumentError, ["depth", "5", "1 to 4"]),
    "look-ahead scenarios": (lambda: LookAhead(MODEL, scenarios=0), ArgumentError, ["scenarios", "0", "500"]),
    "threads 0": (despot(threads=0), ArgumentError, ["threads", "0", "1", "1024"]),
    "seed": (despot(seed=-1), ArgumentError, ["seed", "-1", "0", "18446744073709551615"]),
    "tree of no depth": (lambda: PLAN.tree(-1), ArgumentError, ["depth", "-1", "0", "1000"]),
    "tree too deep": (lambda: PLAN.tree(1001), ArgumentError, ["depth", "1001", "0", "1000"]),
    "threshold 0": (lambda: Threshold(MODEL, 0.0), ArgumentError, ["threshold", "0", "1", "0.94"]),
    "threshold 2": (lambda: InformationGain(MODEL, 2.0), ArgumentError, ["threshold", "2", "0", "1"]),
    "threshold viewpoint": (
        lambda: Threshold(MODEL, 0.9, 5),
        ArgumentError,
        ["viewpoint", "5", "0", "1", "v0, v1"],
    ),
    "gain positions": (lambda: InformationGain(MODEL, 0.9, 3), ArgumentError, ["positions", "3", "2", "1"]),
    "no gain positions": (lambda: InformationGain(MODEL, 0.9, -1), ArgumentError, ["positions", "-1", "1"]),
    "Move": (lambda: Move(-1), ArgumentError, ["viewpoint", "-1", "0"]),
    "Decide": (lambda: Decide(-1), ArgumentError, ["label", "-1", "0"]),
    "batches 0": (evaluation(batches=0), ArgumentError, ["batches", "0", "1", "2147483648"]),
    "batches negative": (evaluation(batches=-1), ArgumentError, ["batches", "-1", "1"]),
    "batch size": (evaluation(batch_size=0), ArgumentError, ["batch_size", "0", "1", "2147483648"]),
    "max_looks": (evaluation(max_looks=0), ArgumentError, ["max_looks", "0", "1", "2147483648"]),
    "evaluation seed": (evaluation(seed=-1), ArgumentError, ["seed", "-1", "0", "18446744073709551615"]),
    "evaluation threads": (evaluation(threads=0), ArgumentError, ["threads", "0", "1", "1024"]),
    "evaluation viewpoint": (evaluation(viewpoint=2), ArgumentError, ["viewpoint", "2", "0", "1", "v0, v1"]),
    "true class": (evaluation(true_classes=[3]), ArgumentError, ["class", "3", "c0, c1, c2"]),
    "negative true class": (evaluation(true_classes=[-1]), ArgumentError, ["true", "class", "-1", "0"]),
    "no true class": (evaluation(true_classes=[]), ArgumentError, ["true_classes", "empty"]),
    "true class in an array": (
        evaluation(true_classes=np.full((2, 11), 3)),
        ArgumentError,
        ["class", "3", "c0, c1, c2"],
    ),
    "negative in an array": (
        evaluation(true_classes=np.full((2, 11), -1)),
        ArgumentError,
        ["true_classes", "-1", "(batches, batch_size + H - 1)"],
    ),
    "half a class": (evaluation(true_classes=np.full((2, 11), 0.5)), ArgumentError, ["true_classes", "0.5"]),
    "true_classes shape": (
        evaluation(true_classes=[[0] * 10] * 2),
        ArgumentError,
        ["true_classes", "(2, 11)", "batch_size + H - 1"],
    ),
    "true_classes of words": (
        evaluation(true_classes="ab"),
        ArgumentError,
        ["true_classes", "ab"],
    ),
    "truth": (
        evaluation(truth=random_model(0, h=1)),
        ArgumentError,
        ["truth", "(1, 2, 3, 3)", "(2, 2, 3, 3)"],
    ),
    "no policy": (
        lambda: evaluate(MODEL, 3),  # type: ignore[arg-type] # the mistake under test
        PolicyError,
        ["policy", "3", "act(belief, viewpoint)"],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_input(case: str) -> None:
    check_refused(CASES[case])


def test_a_policy_that_names_no_action() -> None:
    class Silent:
        def act(self, belief: Belief, viewpoint: int) -> None: ...

    with pytest.raises(PolicyError, match=r"None.*beltsort\.Move"):
        evaluate(MODEL, Silent(), batches=1)  # type: ignore[arg-type] # the mistake under test
