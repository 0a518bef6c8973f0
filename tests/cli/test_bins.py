"""Commands name decisions by bins, looks by labels and objects by classes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort import Belief, Despot, SortingModel, Threshold, evaluate
from beltsort.cli import main
from beltsort.cli.arguments import parse_classes
from beltsort.cli.plan import parse_scan
from beltsort.planning.bins import sorting_statistics
from beltsort.planning.explanation import explain, reason

LOOKS = [[0.7, 0.2, 0.1], [0.2, 0.7, 0.1], [0.05, 0.15, 0.8]]
MODEL = SortingModel(
    ["nut", "bolt", "cap"],
    ["front"],
    [[LOOKS], [LOOKS]],
    labels=["metal, round", "metal", "plastic"],
    bins=["steel", "polymer", "manual"],
    reward=[[10.0, 10.0, -100.0], [-20.0, -20.0, 10.0], [-3.0, -3.0, -3.0]],
)


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "model.json"
    MODEL.save(path)
    return str(path)


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(list(arguments)) == 0
    return capsys.readouterr().out


def json_said(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    result: dict[str, Any] = json.loads(said(capsys, *arguments, "--json"))
    return result


def test_scans_are_of_labels() -> None:
    assert parse_scan("front=metal, round,plastic", MODEL) == (0, [0, 2])
    assert parse_scan("front=metal,-", MODEL) == (0, [1, None])
    assert parse_scan("front=2,metal, round", MODEL) == (0, [2, 0])
    assert parse_classes("nut,2", MODEL) == [0, 2]


def test_a_class_is_no_label(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", file, "--observe", "front=nut,-"]) == 2
    assert "there is no label 'nut'; did you mean" in capsys.readouterr().err


def test_plan_names_classes_and_bins(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--trials", "20", *["--observe", "front=metal, round,metal"] * 3]
    text = said(capsys, "plan", file, *options, "--explain", "--whole-tree")
    assert text.splitlines()[1].split() == ["position", "nut", "bolt", "cap"]
    for expected in (
        "Next: sort into bin steel.",
        "sort into bin polymer ",
        "sort into bin manual ",
        "Deciding bin steel now is right with ",
        "the next object is ",
    ):
        assert expected in text
    result = json_said(capsys, "plan", file, *options, "--explain", "--whole-tree")
    assert result["action"] == {"decide": "steel"}
    assert list(result["belief"][0]) == MODEL.classes
    named = [value["action"].get("decide") for value in result["values"]]
    assert {"steel", "polymer", "manual"} < set(named)
    looked = next(action for action in result["tree"]["actions"] if "move" in action["action"])
    assert set(looked["branches"][0]["labels"]) <= set(MODEL.labels)


def test_labels_with_commas_are_quoted() -> None:
    text = explain(MODEL, Despot(MODEL, trials=50).plan(Belief(MODEL, [[0.6, 0.2, 0.2]] * 2)))
    assert 'if it says "metal, round", ' in text
    assert "then " in text


def test_a_decision_is_right_for_all_classes_of_its_bin() -> None:
    belief = Belief(MODEL, [[0.5, 0.45, 0.05]] * 2)
    plan = Despot(MODEL, trials=20).plan(belief)
    assert "bin steel now" in reason(MODEL, plan, belief.probabilities[0].tolist())
    assert "right with 95 %" in reason(MODEL, plan, belief.probabilities[0].tolist())


def test_nothing_belongs_into_a_manual_bin() -> None:
    unsure = MODEL.replace(reward=[[1, 1, -100], [-90, -90, 1], [-1, -1, -1]])
    belief = Belief(unsure, [[0.25, 0.25, 0.5]] * 2)
    plan = Despot(unsure, trials=20).plan(belief)
    text = reason(unsure, plan, belief.probabilities[0].tolist())
    assert "Deciding bin manual now " in text
    assert "right with" not in text


def test_evaluate_reports_the_bins(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    expected = sorting_statistics(MODEL, evaluate(MODEL, Threshold(MODEL, 0.9), batches=20))
    options = ["evaluate", file, "--policy", "threshold", "--threshold", "0.9", "--batches", "20"]
    assert json_said(capsys, *options)["sorting"] == expected.to_dict()
    text = said(capsys, *options)
    assert str(expected) in text
    assert f"reward of decisions, without moves: {expected.reward}" in text


def test_compare_reports_the_bins(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["compare", file, "--policies", "threshold:0.9", "threshold:0.8", "--batches", "20"]
    text = said(capsys, *options)
    for bin_name in MODEL.bins:
        assert f"{bin_name}: purity" in text
    confusion = json_said(capsys, *options)["sorting"]["threshold:0.8"]["confusion"]["value"]
    assert np.sum(confusion) == pytest.approx(10.0)
