"""What a REPL and a notebook show."""

from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from beltsort import (
    Belief,
    Decide,
    Despot,
    InformationGain,
    LookAhead,
    Move,
    OneObject,
    SortingModel,
    Threshold,
    compare,
    evaluate,
    solve,
)
from beltsort.planning.display import html, text

from .models import beyond_model, random_model


class Cells(HTMLParser):
    """The texts of a fragment of HTML, which must be well-formed and of harmless tags."""

    TAGS = ("div", "table", "tr", "td", "th", "pre")

    def __init__(self, fragment: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.texts: list[str] = []
        self.feed(fragment)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in self.TAGS
        assert [name for name, _ in attrs] in ([], ["style"])
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def shown(thing: Any) -> list[str]:
    return Cells(thing._repr_html_()).texts


def test_models_show_sizes_and_what_is_unusual(paper: SortingModel) -> None:
    first, *plain = repr(paper).splitlines()
    assert first == "SortingModel: 4 classes, 3 viewpoints, 2 positions"
    assert "  rewards     10 for a right decision, -50 for a wrong one, -1 for a move" in plain
    assert len(plain) == 4
    unusual = paper.replace(
        repeat=0.5,
        empty="livarno",
        travel=[[0], [0, 1], [0, 1, 2]],
        observe_after_decision=True,
        information_gain=0.5,
        arrival=[0.7, 0.1, 0.1, 0.1],
        motion_cost=[[0, 1, 2], [1, 0, 1], [2, 1, 0]],
    )
    lines = [" ".join(line.split()) for line in repr(unusual).splitlines()]
    for line in (
        "rewards 10 for a right decision, -50 for a wrong one, -2 to 0 for a move",
        "arrival elongated 0.7, livarno 0.1, mushroom 0.1, standard 0.1",
        "travel a move reaches 1 to 3 of 3 viewpoints",
        "repeat a look repeats the last label with probability 0.5",
        "scans one follows each decision",
        "information 0.5 per nat",
        "empty cups class livarno",
    ):
        assert line in lines
    assert "a look repeats the last label with probability 0.5" in shown(unusual)


def test_models_show_modes_labels_and_bins() -> None:
    lines = [" ".join(line.split()) for line in repr(beyond_model(0)).splitlines()]
    for line in (
        "modes 1 to 2 per class, 4 kinds",
        'labels "seen, sure", "seen"',
        "bins one, manual",
        "rewards -50 to 10 for a decision, by bin and class, -1 for a move",
    ):
        assert line in lines


def test_long_lists_of_names_are_cut() -> None:
    lines = repr(random_model(0, k=20, n=9)).splitlines()
    assert lines[1].endswith("v0, v1, v2, v3, v4, v5, v6 and 13 more")


def test_beliefs_are_tables_with_names(paper: SortingModel) -> None:
    belief = Belief(paper, [[0.1, 0.2, 0.3, 0.4], [0.25] * 4], remaining=1)
    assert repr(belief).splitlines() == [
        "Belief, 1 object left",
        "  position  elongated  livarno  mushroom  standard",
        "  1             0.100    0.200     0.300     0.400",
        "  2             0.250    0.250     0.250     0.250",
    ]
    assert shown(belief)[:6] == ["Belief, 1 object left", "position", *paper.classes]
    repeating = Belief(paper.replace(repeat=0.5))
    repeating.observe("p2", ["mushroom", None])
    assert repr(repeating).endswith("\n  last labels of position 1: mushroom from p2")
    assert shown(repeating)[-7:] == ["last label from", "p1", "p2", "p3", "1", "mushroom", "2"]


def test_beliefs_of_many_classes_show_the_likeliest() -> None:
    model = random_model(0, n=30)
    row = np.full(30, 0.5 / 28)
    row[[7, 9]] = 0.3, 0.2
    assert repr(Belief(model, [row, row])).splitlines()[1] == (
        "  position 1  c7 0.300, c9 0.200, c0 0.018, c1 0.018, ..."
    )


def test_plans_name_their_action(paper: SortingModel) -> None:
    plan = Despot(paper, trials=30).plan(Belief(paper))
    assert isinstance(plan.action, Move)
    viewpoint = paper.viewpoints[plan.action.viewpoint]
    assert repr(plan) == (
        f"Plan(move to {viewpoint} and scan, value {plan.values[plan.action]:.2f}, "
        f"optimum from {plan.certified_lower:.2f} to {plan.certified_upper:.2f}, 30 trials)"
    )
    cells = shown(plan)
    assert cells[0] == f"Plan: move to {viewpoint} and scan"
    assert cells[4:7] == [f"move to {viewpoint} and scan", f"{plan.values[plan.action]:.2f}", "0.00"]
    assert f"{plan.certified_lower:.2f} to {plan.certified_upper:.2f} (certified)" in cells[-1]
    sure = Despot(paper, trials=1).plan(Belief(paper, [[0.999, 0.001, 0, 0], [0.25] * 4]))
    assert repr(sure).startswith("Plan(sort as elongated, ")
    assert repr(sure).endswith(", 1 trial)")
    repeating = paper.replace(repeat=0.5)
    assert ", optimum at most " in repr(Despot(repeating, trials=1).plan(Belief(repeating)))


def test_long_plans_show_the_best_actions() -> None:
    model = random_model(0, k=20)
    plan = Despot(model, trials=1).plan(Belief(model))
    cells = shown(plan)
    assert cells[-1].endswith("; 11 more actions.")
    assert len(cells) == 1 + 3 * (1 + 12) + 1


def test_policies_show_their_settings(paper: SortingModel) -> None:
    sizes = "<4 classes, 3 viewpoints, 2 positions>"
    assert repr(Threshold(paper, 0.94)) == f"Threshold({sizes}, threshold=0.94)"
    assert repr(Threshold(paper, 0.94, 2)) == f"Threshold({sizes}, threshold=0.94, viewpoint='p3')"
    gain = InformationGain(paper, 0.9, 2, about="bin")
    assert repr(gain) == f"InformationGain({sizes}, threshold=0.9, positions=2, about='bin')"
    assert repr(OneObject(paper)) == f"OneObject({sizes})"
    assert repr(LookAhead(paper, 2)) == f"LookAhead({sizes}, depth=2, scenarios=500, seed=0)"
    planner = Despot(paper, trials=3, seed=7)
    assert repr(planner) == f"Despot({sizes}, scenarios=500, seed=7, trials=3, variant='beliefs')"
    published = Despot(paper, seconds=0.1, scenarios=5, regularization=0.1, variant="scenarios")
    assert repr(published) == (
        f"Despot({sizes}, scenarios=5, seed=0, seconds=0.1, regularization=0.1, variant='scenarios')"
    )
    assert shown(Threshold(paper, 0.94, 2))[-2:] == ["viewpoint", "p3"]


def test_solutions_show_their_bounds() -> None:
    solution = solve(random_model(0, h=1), seconds=0.2)
    assert repr(solution).startswith(
        f"Solution(<3 classes, 2 viewpoints, 1 position>, optimum from {solution.lower:.4f} to "
    )
    assert f"from {solution.lower:.4f} to {solution.upper:.4f}, at the arrival prior" in shown(solution)


def test_evaluations_show_means_and_standard_errors(paper: SortingModel) -> None:
    result = evaluate(paper, Threshold(paper, 0.9), batches=20)
    found = result.summary()["expected_discounted_returns"]
    mean = f"{found['mean']:.3f} ± {found['standard_error']:.3f}"
    first, *rows = repr(result).splitlines()
    assert first == "Evaluation of 20 batches, mean ± standard error"
    assert rows[-1].split("  ")[1:] == ["expected discounted returns", mean]
    assert shown(result)[-2:] == ["expected discounted returns", mean]
    assert "±" not in repr(evaluate(paper, Threshold(paper, 0.9), batches=1))


def test_comparisons_show_their_table(paper: SortingModel) -> None:
    policies = {"careful": Threshold(paper, 0.95), "a & b <script>": Threshold(paper, 0.8)}
    comparison = compare(paper, policies, batches=20)
    assert repr(comparison) == str(comparison)
    cells = shown(comparison)
    difference = comparison.difference("a & b <script>", "steps")
    assert f"{difference.mean:+.3f} ± {difference.standard_error:.3f} ({difference.z:+.1f})" in cells
    assert cells.count("a & b <script>") == 2
    assert "<script>" not in comparison._repr_html_()


def test_names_are_escaped() -> None:
    names = ["<script>alert(1)</script>", "a & b"]
    model = SortingModel(names, ['"p"'], [[[[0.8, 0.2], [0.2, 0.8]]]])
    planner = Despot(model, trials=2)
    for thing in (model, Belief(model), planner.plan(Belief(model)), planner, solve(model, seconds=0.1)):
        assert "<script>" not in thing._repr_html_()
    assert names[0] in shown(Belief(model))


def test_actions_are_shown_as_they_are_made() -> None:
    assert repr([Move(2), Decide(1)]) == "[Move(viewpoint=2), Decide(label=1)]"


@pytest.mark.parametrize("show", [text, html])
def test_other_objects_have_nothing_to_show(show: Any) -> None:
    with pytest.raises(TypeError, match="int has no"):
        show(1)
