"""`beltsort plan --explain`: the searched tree in words and as data."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import beltsort
from beltsort.planning.explanation import chosen_part, explain

from .running import PAPER, command, json_of, output

pytestmark = pytest.mark.slow

SEEN = ("plan", PAPER, "--observe", "p3=mushroom,standard", "--trials", "200")


def planned(model: beltsort.SortingModel, **settings: Any) -> beltsort.Plan:
    belief = beltsort.Belief(model)
    belief.observe(2, [2, 3])
    return beltsort.Despot(model, trials=200, **settings).plan(belief, 2)


@pytest.fixture(scope="module")
def paper() -> beltsort.SortingModel:
    return beltsort.SortingModel.load(PAPER)


def test_in_words(paper: beltsort.SortingModel) -> None:
    text = output(*SEEN, "--explain")
    assert text.endswith(f"\n\n{explain(paper, planned(paper))}\n")
    assert text.startswith(output(*SEEN).rsplit(" trials in", 1)[0])
    values = r"right with 73 % and worth \d\d\.\d; one more look, from p3, is worth \d\d\.\d\."
    assert re.search(rf"Deciding mushroom now would be {values}\n", text)
    assert "  if it says mushroom, standard (19 %): 93 % mushroom, then sort as mushroom\n" in text


def test_what_actions_lack_of_the_best(paper: beltsort.SortingModel) -> None:
    lines = re.findall(r"^  (?:move|sort).* (-?\d+\.\d+) +(\d+\.\d+)$", output(*SEEN), re.MULTILINE)
    assert len(lines) == 7
    best = float(lines[0][0])
    for value, lacking in lines:
        assert best - float(value) == pytest.approx(float(lacking), abs=0.0011)


@pytest.mark.parametrize("depth", [0, 1, 2, 3])
def test_deeper_explanations_say_more(paper: beltsort.SortingModel, depth: int) -> None:
    text = explain(paper, planned(paper), depth)
    assert ("if it says" in text) == (depth > 0)
    assert (", then " in text) == (depth > 1)
    assert ("\n      the next object is" in text) == (depth > 2)


def test_a_decision_and_what_comes_after_it(paper: beltsort.SortingModel) -> None:
    belief = beltsort.Belief(paper, [[0.01, 0.97, 0.01, 0.01], [0.7, 0.1, 0.1, 0.1]])
    text = explain(paper, beltsort.Despot(paper, trials=50).plan(belief))
    assert re.match(r"Deciding livarno now is right with 97 % and worth .* would be worth", text)
    assert "After 'sort as livarno', most likely:\n  the next object is 70 % elongated, then move to" in text


def test_where_no_move_is_allowed(paper: beltsort.SortingModel) -> None:
    bound = beltsort.SortingModel(paper.classes, paper.viewpoints, paper.p_obs, travel=[[], [], []])
    text = explain(bound, planned(bound))
    assert text.startswith("No move is allowed from here; deciding mushroom is right with 73 %.\n")


def beliefs(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    yield node
    for action in node["actions"]:
        for branch in action["branches"]:
            yield from beliefs(branch["node"])


def test_as_data(paper: beltsort.SortingModel) -> None:
    tree = json_of(*SEEN, "--explain", "--depth", "1", "--whole-tree")["tree"]
    expected = planned(paper).tree(1)
    assert [list(row.values()) for row in tree["belief"]] == expected["belief"]
    assert tree["actions"][0]["action"] == {"decide": "mushroom"}
    assert tree["actions"][3]["action"] == {"move": "p3"}
    assert tree["actions"][3]["branches"][0]["labels"] == ["mushroom", "standard"]
    assert tree["actions"][0]["branches"][0]["labels"] is None
    assert {node["viewpoint"] for node in beliefs(tree)} == set(paper.viewpoints)
    assert len(list(beliefs(tree))) == 1 + sum(len(action["branches"]) for action in expected["actions"])
    assert "tree" not in json_of(*SEEN)
    part = json_of(*SEEN, "--explain")["tree"]
    assert [action["value"] for action in part["actions"]] == [
        action["value"] for action in expected["actions"]
    ]
    assert sum(bool(action["branches"]) for action in part["actions"]) == 1


def test_a_bad_depth_is_one_line() -> None:
    done = command(*SEEN, "--explain", "--depth", "-1")
    assert done.returncode == 2
    assert re.fullmatch(r"beltsort: error: .*\bdepth\b.*-1\b.*\b0\b.*\b1000\b.*\n", done.stderr)


def test_without_a_certified_lower_bound(paper: beltsort.SortingModel, tmp_path: Path) -> None:
    repeating = beltsort.SortingModel(paper.classes, paper.viewpoints, paper.p_obs, repeat=0.5)
    repeating.save(tmp_path / "model.json")
    model = str(tmp_path / "model.json")
    assert re.search(r"Certified bounds of the optimal value: at most \d+\.\d+\.\n", output("plan", model))
    assert json_of("plan", model)["certified_lower"] is None


def test_the_chosen_part_has_all_values_and_what_follows_the_best(paper: beltsort.SortingModel) -> None:
    plan = planned(paper)
    whole = plan.tree(3)
    part = chosen_part(whole, plan.action)
    assert [action["value"] for action in part["actions"]] == [action["value"] for action in whole["actions"]]
    (followed,) = [action for action in part["actions"] if action["branches"]]
    assert beltsort.Move(followed["action"]["move"]) == plan.action
    assert 1 <= len(followed["branches"]) <= 4
    for branch in followed["branches"]:
        assert len(branch["node"]["actions"]) <= 1
    assert len(list(beliefs(dict(part)))) <= 1 + 4 + 16 + 64


def test_classes_that_are_equally_likely_are_all_named(paper: beltsort.SortingModel) -> None:
    blind = paper.replace(p_obs=[[[[0.25] * 4] * 4] * 3] * 2)
    text = explain(blind, beltsort.Despot(blind, trials=20).plan(beltsort.Belief(blind)))
    assert "any class, 25 % each" in text
