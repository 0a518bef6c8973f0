"""Viewpoints, labels and classes by name."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    Belief,
    Despot,
    InformationGain,
    LookAhead,
    OneObject,
    SortingModel,
    Threshold,
    compare,
    evaluate,
    solve,
)
from beltsort.planning.policy import Policy

from .models import beyond_model


def test_scans_by_name(paper: SortingModel) -> None:
    named, numbered = Belief(paper), Belief(paper)
    named.observe("p3", ["mushroom", None])
    numbered.observe(2, [paper.classes.index("mushroom"), None])
    assert named == numbered
    named.observe("p1", [1, "standard"])  # names and numbers may be mixed
    numbered.observe(0, [1, 3])
    assert named == numbered
    assert np.array_equal(named.label_probabilities("p2"), numbered.label_probabilities(1))


def test_labels_are_named_by_the_labels_of_the_model() -> None:
    model = beyond_model(0)
    belief, numbered = Belief(model), Belief(model)
    belief.observe("v1", ["seen, sure", "seen"])
    numbered.observe(1, [0, 1])
    assert belief == numbered
    with pytest.raises(ArgumentError, match=r'no label "c1"; did you mean "seen.*0 to 1'):
        belief.observe("v1", ["c1", None])


def test_policies_take_the_viewpoint_by_name(paper: SortingModel) -> None:
    belief = Belief(paper)
    planner, solution = Despot(paper, trials=5, scenarios=20), solve(paper, seconds=0.2)
    assert planner.plan(belief, viewpoint="p3").values == planner.plan(belief, 2).values
    assert solution.bounds(belief, "p2") == solution.bounds(belief, 1)
    policies: list[Any] = [
        planner,
        solution,
        OneObject(paper),
        LookAhead(paper),
        InformationGain(paper, 0.9),
    ]
    for policy in policies:
        assert policy.act(belief, "p2") == policy.act(belief, 1)
    for look in range(3):
        by_name = Threshold(paper, 0.9, paper.viewpoints[look])
        assert by_name.act(belief, 0) == Threshold(paper, 0.9, look).act(belief, "p1")


def test_evaluation_by_name(paper: SortingModel) -> None:
    policy = Threshold(paper, 0.9)
    named = evaluate(paper, policy, batches=5, viewpoint="p2", true_classes=["mushroom", "standard"])
    numbered = evaluate(paper, policy, batches=5, viewpoint=1, true_classes=[2, 3])
    assert named.returns.tolist() == numbered.returns.tolist()
    rows = np.random.default_rng(0).integers(4, size=(5, 11))
    by_object = [[paper.classes[label] for label in row] for row in rows]
    for given in (by_object, np.array(by_object)):
        named = evaluate(paper, policy, batches=5, true_classes=given)
        assert (
            named.returns.tolist() == evaluate(paper, policy, batches=5, true_classes=rows).returns.tolist()
        )
    policies: dict[str, Policy] = {"a": policy, "b": OneObject(paper)}
    compared = compare(paper, policies, batches=3, viewpoint="p2", true_classes=["mushroom"])
    assert compared.outcomes("a", "steps").tolist() == (
        evaluate(paper, policy, batches=3, viewpoint=1, true_classes=[2]).steps.tolist()
    )


UNKNOWN: dict[str, tuple[Callable[[SortingModel], object], str]] = {
    "viewpoint of a scan": (
        lambda model: Belief(model).observe("p33", [0, 0]),
        'there is no viewpoint "p33"; did you mean "p3"? Known: p1, p2, p3, or 0 to 2',
    ),
    "label": (
        lambda model: Belief(model).observe(0, ["mushrom", 0]),
        'there is no label "mushrom"; did you mean "mushroom"? Known: elongated, livarno, mushroom, '
        "standard, or 0 to 3",
    ),
    "viewpoint of a plan": (
        lambda model: Despot(model, trials=1).plan(Belief(model), "3"),
        'there is no viewpoint "3"; did you mean "p3"?',
    ),
    "viewpoint of a policy": (lambda model: Threshold(model, 0.9, "front"), 'there is no viewpoint "front"'),
    "viewpoint of an evaluation": (
        lambda model: evaluate(model, Threshold(model, 0.9), viewpoint="p"),
        'there is no viewpoint "p"',
    ),
    "true class": (
        lambda model: evaluate(model, Threshold(model, 0.9), true_classes=["livarna"]),
        'there is no class "livarna"; did you mean "livarno"?',
    ),
    "true class of an object": (
        lambda model: evaluate(model, Threshold(model, 0.9), batches=1, true_classes=[["livarna"] * 11]),
        'there is no class "livarna"; did you mean "livarno"?',
    ),
}


@pytest.mark.parametrize("case", UNKNOWN)
def test_unknown_names_are_refused_with_the_nearest(case: str, paper: SortingModel) -> None:
    call, message = UNKNOWN[case]
    with pytest.raises(ArgumentError) as raised:
        call(paper)
    assert message in str(raised.value)


def test_a_refused_name_leaves_the_belief(paper: SortingModel) -> None:
    belief = Belief(paper)
    with pytest.raises(ArgumentError):
        belief.observe("p1", ["mushroom", "mushrom"])
    assert belief == Belief(paper)


def test_what_is_neither_a_name_nor_a_number(paper: SortingModel) -> None:
    with pytest.raises(TypeError):
        Belief(paper).observe(1.5, [0, 0])  # type: ignore[arg-type] # what it is about
