"""Bad input is one exception under BeltsortError, with value, expectation and remedy."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from beltsort import (
    ArgumentError,
    Belief,
    BeltsortError,
    Decide,
    Despot,
    ImpossibleObservationError,
    InformationGain,
    ModelError,
    Move,
    OneObject,
    PolicyError,
    SortingModel,
    Threshold,
    evaluate,
    solve,
)

from .models import random_model

TABLES = [[[[0.5, 0.5], [0.1, 0.9]]]]
MODEL = random_model(0)
OTHER = random_model(1)
REPEATING = random_model(0, repeat=0.5)
THRESHOLD = Threshold(MODEL, 0.9)
PLAN = Despot(MODEL, trials=1).plan(Belief(MODEL))


def model(p_obs: ArrayLike = TABLES, **settings: Any) -> Callable[[], object]:
    arguments: dict[str, Any] = {"classes": ["a", "b"], "viewpoints": ["v"]} | settings
    return lambda: SortingModel(p_obs=p_obs, **arguments)


def file(**keys: object) -> Callable[[], object]:
    return lambda: SortingModel.from_json(json.dumps({"classes": ["a", "b"], "viewpoints": ["v"]} | keys))


def evaluation(**settings: Any) -> Callable[[], object]:
    return lambda: evaluate(MODEL, THRESHOLD, **{"batches": 2, **settings})


def despot(**settings: Any) -> Callable[[], object]:
    return lambda: Despot(MODEL, **settings)


def plan(*arguments: Any, **settings: Any) -> Callable[[], object]:
    return lambda: Despot(MODEL, trials=1).plan(Belief(MODEL), *arguments, **settings)


def observe(viewpoint: int, labels: list[Any]) -> Callable[[], object]:
    return lambda: Belief(MODEL).observe(viewpoint, labels)


CASES: dict[str, tuple[Callable[[], object], type[BeltsortError], list[str]]] = {
    "row sum": (model([[[[0.5, 0.6], [0.1, 0.9]]]]), ModelError, ["1.1", "sum to 1", "Divide"]),
    "negative entry": (model([[[[-0.5, 1.5], [0.1, 0.9]]]]), ModelError, ["-0.5", "not negative"]),
    "NaN entry": (model([[[[np.nan, 0.5], [0.1, 0.9]]]]), ModelError, ["NaN", "finite"]),
    "axes": (model([[0.5, 0.5], [0.1, 0.9]]), ModelError, ["[2, 2]", "(H, K, L, L)"]),
    "viewpoints in p_obs": (model(TABLES, viewpoints=["v", "w"]), ModelError, ["1 entries", "expected 2"]),
    "classes in p_obs": (model(TABLES, classes=["a", "b", "c"]), ModelError, ["2 entries", "expected 3"]),
    "no positions": (model(np.zeros((0, 1, 2, 2))), ModelError, ["no position", "at least 1"]),
    "ragged p_obs": (model([[[[0.5, 0.5], [1.0]]]]), ModelError, ["p_obs", "inhomogeneous", "equal lengths"]),
    "p_obs of words": (model("tables"), ModelError, ["tables", "nested lists"]),
    "one class": (model([[[[1.0]]]], classes=["a"]), ModelError, ["classes has 1", "at least 2"]),
    "same name": (model(classes=["a", "a"]), ModelError, ['"a" twice', "unique"]),
    "discount 1": (model(discount=1.0), ModelError, ["discount = 1", "between 0 and 1", "0.95"]),
    "discount 0": (model(discount=0.0), ModelError, ["discount = 0", "between 0 and 1", "0.95"]),
    "r_min 0": (model(r_min=0.0), ModelError, ["r_min = 0", "above 0", "without its sign"]),
    "r_min negative": (model(r_min=-50.0), ModelError, ["r_min = -50", "above 0", "without its sign"]),
    "r_max infinite": (model(r_max=np.inf), ModelError, ["r_max = inf", "finite"]),
    "arrival length": (
        model(arrival=[1.0]),
        ModelError,
        ["1 entries", "2 classes", "one probability per class"],
    ),
    "arrival sum": (model(arrival=[0.5, 0.4]), ModelError, ["0.9", "sum to 1", "Divide"]),
    "motion cost shape": (model(motion_cost=[[1.0, 1.0]]), ModelError, ["2 entries", "expected 1"]),
    "motion cost ragged": (model(motion_cost=[[1.0], []]), ModelError, ["motion_cost", "equal lengths"]),
    "motion cost negative": (model(motion_cost=-1.0), ModelError, ["-1", "not negative", "travel"]),
    "travel too far": (model(travel=[[1]]), ModelError, ["viewpoint 1", "0 to 0"]),
    "travel negative": (model(travel=[[-1]]), ModelError, ["viewpoint -1", "from 0"]),
    "travel length": (model(travel=[]), ModelError, ["0 entries", "expected 1"]),
    "counts shape": (model(counts=[[[[1, 2]]]]), ModelError, ["counts", "(H, K, L, L)"]),
    "counts negative": (model(counts=[[[[-1, 2], [3, 4]]]]), ModelError, ["-1", "not negative"]),
    "counts broken": (model(counts=[[[[0.5, 2], [3, 4]]]]), ModelError, ["0.5", "whole numbers"]),
    "smoothing": (model(smoothing=-1.0), ModelError, ["smoothing = -1", "not negative"]),
    "repeat 1": (model(repeat=1.0), ModelError, ["repeat holds 1", "below 1"]),
    "repeat negative": (model(repeat=-0.1), ModelError, ["repeat holds -0.1", "at least 0"]),
    "repeat NaN": (model(repeat=[[np.nan]]), ModelError, ["repeat holds NaN", "below 1"]),
    "repeat positions": (model(repeat=[[0.5], [0.5]]), ModelError, ["2 entries", "expected 1", "position"]),
    "repeat viewpoints": (
        model(repeat=[[0.5, 0.5]]),
        ModelError,
        ["repeat[0]", "2 entries", "expected 1", "viewpoint"],
    ),
    "information gain": (model(information_gain=-1.0), ModelError, ["information_gain = -1", "not negative"]),
    "infinite gain": (model(information_gain=np.inf), ModelError, ["information_gain = inf", "finite"]),
    "empty class": (model(empty="c"), ModelError, ['empty = "c"', "(a, b)", "leave it out"]),
    "solve repeats": (lambda: solve(REPEATING), ModelError, ["repeat is set", "leave it out"]),
    "solve scans after decisions": (
        lambda: solve(random_model(0, observe_after_decision=True)),
        ModelError,
        ["observe_after_decision is set", "Threshold"],
    ),
    "solve bonuses": (
        lambda: solve(random_model(0, information_gain=0.1)),
        ModelError,
        ["information_gain is set", "Threshold"],
    ),
    "last labels' shape": (
        lambda: Belief(REPEATING, last_labels=[[0, 1]]),
        ArgumentError,
        ["1 rows of lengths [2]", "expected shape (2, 2)"],
    ),
    "last label": (
        lambda: Belief(REPEATING, last_labels=[[0, 3], [0, 0]]),
        ArgumentError,
        ["label 3", "0 to 2"],
    ),
    "negative last label": (
        lambda: Belief(REPEATING, last_labels=[[0, -2], [0, 0]]),
        ArgumentError,
        ["last_labels holds -2"],
    ),
    "objects left": (lambda: Belief(MODEL, remaining=-1), ArgumentError, ["remaining = -1", "None"]),
    "nothing left": (
        lambda: Despot(MODEL, trials=1).plan(Belief(MODEL, remaining=0), 0),
        ArgumentError,
        ["remaining = 0", "no object is left"],
    ),
    "regret where the belt ends": (
        lambda: evaluate(MODEL, OneObject(MODEL), reference=solve(MODEL, seconds=0.2), belt_ends=True),
        ArgumentError,
        ["reference", "belt_ends", "leave one of them out"],
    ),
    "unknown key": (file(p_obs=TABLES, discont=0.9), ModelError, ['"discont"', '"discount"', "Known keys"]),
    "missing key": (file(), ModelError, ["missing field `p_obs`"]),
    "wrong type": (file(p_obs=TABLES, r_min="high"), ModelError, ["high", "expected f64"]),
    "no JSON": (lambda: SortingModel.from_json("{"), ModelError, ["JSON"]),
    "no object": (lambda: SortingModel.from_json("[]"), ModelError, ["one JSON object", "classes"]),
    "no file": (lambda: SortingModel.load("absent.json"), ModelError, ["absent.json", "cannot be read"]),
    "no folder": (lambda: MODEL.save("absent/m.json"), ModelError, ["absent/m.json", "cannot be written"]),
    "no positions left": (lambda: MODEL.with_positions(0), ArgumentError, ["positions = 0", "between 1"]),
    "positions to keep": (lambda: MODEL.with_positions(-2), ArgumentError, ["positions = -2", "at least 1"]),
    "label": (observe(0, [3, None]), ArgumentError, ["label 3", "0 to 2", "c0, c1, c2"]),
    "negative label": (observe(0, [-1, None]), ArgumentError, ["label -1", "start at 0"]),
    "labels": (observe(0, [1]), ArgumentError, ["1 labels", "2 positions", "the belt end first"]),
    "viewpoint of a scan": (observe(2, [0, 0]), ArgumentError, ["viewpoint 2", "0 to 1", "v0, v1"]),
    "negative viewpoint": (observe(-1, [0, 0]), ArgumentError, ["viewpoint -1", "start at 0"]),
    "impossible label": (
        lambda: Belief(SortingModel(["a", "b"], ["v"], [[[[1, 0], [1, 0]]]])).observe(0, [1]),
        ImpossibleObservationError,
        ["position 0", "viewpoint v", "label b", "Drop the label"],
    ),
    "belief shape": (
        lambda: Belief(MODEL, [[0.5, 0.5]]),
        ArgumentError,
        ["1 rows of lengths [2]", "expected shape (2, 3)"],
    ),
    "belief axes": (lambda: Belief(MODEL, [0.5, 0.5]), ArgumentError, ["[2]", "two axes"]),
    "belief sum": (lambda: Belief(MODEL, [[1, 1, 0], [1, 0, 0]]), ArgumentError, ["2", "sum to 1", "Divide"]),
    "position": (lambda: Belief(MODEL).most_likely(2), ArgumentError, ["position 2", "0 to 1"]),
    "planned viewpoint": (plan(2), ArgumentError, ["viewpoint 2", "0 to 1"]),
    "negative planned viewpoint": (plan(-1), ArgumentError, ["viewpoint -1", "start at 0"]),
    "belief of another model": (
        lambda: Despot(MODEL, trials=1).plan(Belief(OTHER)),
        ArgumentError,
        ["another model", "Belief(policy.model)"],
    ),
    "belief of another model, policy": (
        lambda: THRESHOLD.act(Belief(OTHER), 0),
        ArgumentError,
        ["another model", "Belief(policy.model)"],
    ),
    "trials 0": (plan(trials=0), ArgumentError, ["trials = 0", "at least 1"]),
    "trials negative": (despot(trials=-3), ArgumentError, ["trials = -3", "at least 1"]),
    "seconds 0": (plan(seconds=0.0), ArgumentError, ["seconds = 0", "above 0", "0.01"]),
    "seconds negative": (despot(seconds=-1.0), ArgumentError, ["seconds = -1", "above 0", "0.01"]),
    "seconds NaN": (despot(seconds=np.nan), ArgumentError, ["seconds = NaN", "above 0"]),
    "both budgets": (plan(seconds=1.0, trials=1), ArgumentError, ["both", "give one"]),
    "both budgets at once": (despot(seconds=1.0, trials=1), ArgumentError, ["both", "give one"]),
    "scenarios 0": (despot(scenarios=0), ArgumentError, ["scenarios = 0", "500"]),
    "scenarios negative": (despot(scenarios=-1), ArgumentError, ["scenarios = -1", "at least 1"]),
    "depth 0": (despot(depth=0), ArgumentError, ["depth = 0", "at least 1"]),
    "regularization": (despot(regularization=-0.1), ArgumentError, ["-0.1", "not negative"]),
    "threads 0": (despot(threads=0), ArgumentError, ["threads = 0", "at least 1"]),
    "seed": (despot(seed=-1), ArgumentError, ["seed = -1", "from 0"]),
    "tree of no depth": (lambda: PLAN.tree(-1), ArgumentError, ["depth = -1", "0 to 1000"]),
    "tree too deep": (lambda: PLAN.tree(1001), ArgumentError, ["depth = 1001", "0 to 1000"]),
    "threshold 0": (lambda: Threshold(MODEL, 0.0), ArgumentError, ["threshold = 0", "above 0", "0.94"]),
    "threshold 2": (lambda: InformationGain(MODEL, 2.0), ArgumentError, ["threshold = 2", "at most 1"]),
    "threshold viewpoint": (lambda: Threshold(MODEL, 0.9, 5), ArgumentError, ["viewpoint 5", "0 to 1"]),
    "gain positions": (lambda: InformationGain(MODEL, 0.9, 3), ArgumentError, ["positions = 3", "has 2"]),
    "no gain positions": (lambda: InformationGain(MODEL, 0.9, -1), ArgumentError, ["positions = -1"]),
    "Move": (lambda: Move(-1), ArgumentError, ["viewpoint -1", "start at 0"]),
    "Decide": (lambda: Decide(-1), ArgumentError, ["label -1", "start at 0"]),
    "batches 0": (evaluation(batches=0), ArgumentError, ["batches = 0", "at least 1"]),
    "batches negative": (evaluation(batches=-1), ArgumentError, ["batches = -1", "at least 1"]),
    "batch size": (evaluation(batch_size=0), ArgumentError, ["batch_size = 0", "at least 1"]),
    "max_looks": (evaluation(max_looks=0), ArgumentError, ["max_looks = 0", "at least 1"]),
    "evaluation seed": (evaluation(seed=-1), ArgumentError, ["seed = -1", "from 0"]),
    "evaluation threads": (evaluation(threads=0), ArgumentError, ["threads = 0", "at least 1"]),
    "evaluation viewpoint": (evaluation(viewpoint=2), ArgumentError, ["viewpoint 2", "0 to 1"]),
    "true class": (evaluation(true_classes=[3]), ArgumentError, ["label 3", "0 to 2"]),
    "negative true class": (evaluation(true_classes=[-1]), ArgumentError, ["-1", "start at 0"]),
    "no true class": (evaluation(true_classes=[]), ArgumentError, ["empty", "at least one"]),
    "true class in an array": (evaluation(true_classes=np.full((2, 11), 3)), ArgumentError, ["label 3"]),
    "negative in an array": (
        evaluation(true_classes=np.full((2, 11), -1)),
        ArgumentError,
        ["-1", "list of labels"],
    ),
    "half a class": (evaluation(true_classes=np.full((2, 11), 0.5)), ArgumentError, ["0.5", "whole numbers"]),
    "true_classes shape": (
        evaluation(true_classes=[[0] * 10] * 2),
        ArgumentError,
        ["(2, 11)", "batch_size + H"],
    ),
    "true_classes of words": (
        evaluation(true_classes="ab"),
        ArgumentError,
        ["true_classes", "list of labels"],
    ),
    "truth": (evaluation(truth=random_model(0, h=1)), ArgumentError, ["(1, 2, 3)", "(2, 2, 3)", "agree"]),
    "no policy": (
        lambda: evaluate(MODEL, 3),  # type: ignore[arg-type] # the mistake under test
        PolicyError,
        ["policy = 3", "act(belief, viewpoint)"],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_input(case: str) -> None:
    call, kind, parts = CASES[case]
    with pytest.raises(BeltsortError) as raised:
        call()
    assert type(raised.value) is kind
    missing = [part for part in parts if part not in str(raised.value)]
    assert not missing, str(raised.value)


def test_a_policy_that_names_no_action() -> None:
    class Silent:
        def act(self, belief: Belief, viewpoint: int) -> None: ...

    with pytest.raises(PolicyError, match=r"returned None; return beltsort\.Move"):
        evaluate(MODEL, Silent(), batches=1)  # type: ignore[arg-type] # the mistake under test
