"""beltsort compare."""

import re
from pathlib import Path

import pytest

from beltsort import Despot, InformationGain, Solution, SortingModel, Threshold, compare, evaluate, solve

from .running import PAPER, command, json_of, output

pytestmark = pytest.mark.slow

POLICIES = ["threshold:0.9", "information-gain:0.9:2", "despot:2"]


def test_compare_says_the_same_as_the_library() -> None:
    model = SortingModel.load(PAPER)
    policies = (Threshold(model, 0.9), InformationGain(model, 0.9, 2), Despot(model, trials=2))
    expected = compare(
        model,
        dict(zip(POLICIES, policies, strict=True)),
        batches=20,
        batch_size=5,
        seed=3,
        baseline="despot:2",
    )
    options = ["--baseline", "despot:2", "--batches", "20", "--batch-size", "5", "--seed", "3"]
    result = json_of("compare", PAPER, "--policies", *POLICIES, *options)
    assert result.pop("command_line").startswith(f"beltsort compare {PAPER} --policies threshold:0.9 ")
    assert result == expected.to_dict()


def test_compare_in_words() -> None:
    options = ["--policies", "threshold:0.9", "despot:0.001s", "solution:0.2s", "--batches", "3"]
    text = output("compare", PAPER, *options, "--true-classes", "livarno,3")
    assert re.search(r"^ +threshold:0.9 +despot:0.001s +solution:0.2s$", text, re.MULTILINE)
    assert "Minus threshold:0.9 in the same batches" in text
    assert re.search(r"^  steps +[+-]\d.*\([+-]", text, re.MULTILINE)
    assert "Made by: beltsort compare" in text


def test_a_belt_that_ends() -> None:
    model = SortingModel.load(PAPER)
    expected = evaluate(model, Despot(model, trials=2), batches=5, batch_size=2, belt_ends=True)
    options = ["--policies", "despot:2", "threshold:0.9", "--batches", "5", "--batch-size", "2"]
    result = json_of("compare", PAPER, *options, "--belt-ends")
    assert result["summary"]["despot:2"] == expected.summary()


def test_a_saved_solution_is_a_policy(tmp_path: Path) -> None:
    path = tmp_path / "paper.solution"
    solution = solve(SortingModel.load(PAPER), seconds=0.3)
    solution.save(path)
    options = ["--policies", "threshold:0.9", f"solution:{path}", "--batches", "3"]
    expected = evaluate(solution.model, solution, batches=3)
    result = json_of("compare", PAPER, *options)
    assert result["summary"][f"solution:{path}"] == expected.summary()
    refused = command("compare", PAPER, "--policies", "despot", f"solution:{path}.missing")
    assert refused.returncode == 2
    assert re.search(r"paper\.solution\.missing\b.*No such file", refused.stderr)


def test_a_changed_model_and_its_reference(tmp_path: Path) -> None:
    path = str(tmp_path / "one.solution")
    changes = ["--positions", "1", "--set", "r_min=5", "--set", "note=one"]
    assert command("solve", PAPER, *changes, "--seconds", "1", "-o", path).returncode == 0
    policies = ["--policies", "threshold:0.9", f"solution:{path}", "--batches", "3"]
    result = json_of("compare", PAPER, *changes, *policies, "--reference", path)
    assert result["summary"]["threshold:0.9"]["regrets"]["mean"] > 0.0
    assert result["summary"][f"solution:{path}"]["regrets"]["mean"] == 0.0
    refused = command("compare", PAPER, *policies, "--reference", path)
    assert re.search(r"solution\b.*\bmodel: \w", refused.stderr)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("rmin=5", r"--set rmin=5\b.*'rmin'.*'r_min'.*\bclasses, "),
        ("r_min", r"--set r_min\b.*\bKEY=VALUE\b"),
        ("r_min=-5", r"\br_min\b.*-5\b.*\b0\b"),
        ("travel=[[0]]", r"\btravel\b.*\b1\b.*\b3\b"),
    ],
)
def test_changes_that_make_no_model_are_refused(change: str, message: str) -> None:
    done = command("evaluate", PAPER, "--policy", "despot", "--set", change)
    assert done.returncode == 2
    assert re.fullmatch(rf"beltsort: error: .*{message}.*\n", done.stderr)


@pytest.mark.parametrize(
    ("policies", "message"),
    [
        (["threshold:0.9", "random"], r"policy 'random'.*\bdespot\b"),
        (["threshold:0.9", "threshold"], r"'threshold'.*\bthreshold:T\b"),
        (["threshold:0.9", "threshold:high"], r"'threshold:high'.*\bthreshold:T\b"),
        (["threshold:0.9", "threshold:1.5"], r"\bthreshold\b.*\b1\.5\b.*\b0\b.*\b1\b"),
        (["threshold:0.9", "despot:2:3"], r"'despot:2:3'.*\bdespot\[:TRIALS\]"),
        (["threshold:0.9", "solution:3"], r"\b3\b.*\b3s\b"),
        (["despot", "despot"], r"--policies despot despot\b"),
        (["despot"], r"\b1 policies\b"),
    ],
)
def test_errors_are_one_line(policies: list[str], message: str) -> None:
    done = command("compare", PAPER, "--policies", *policies, "--batches", "1", "--json")
    assert done.returncode == 2
    assert done.stdout == ""
    assert re.fullmatch(rf"beltsort: error: .*{message}.*\n", done.stderr)


def test_losses_on_a_model_with_three_positions(tmp_path: Path) -> None:
    model, path = str(tmp_path / "three.json"), str(tmp_path / "three.solution")
    paper = SortingModel.load(PAPER)
    paper.replace(p_obs=[*paper.p_obs, paper.p_obs[-1]]).save(model)
    assert command("solve", model, "--seconds", "2", "-o", path).returncode == 0
    options = ["--policies", "one-object", "threshold:0.9", "--batches", "20", "--batch-size", "40"]
    options += ["--reference", path]
    result = json_of("compare", model, *options)["loss_bounds"]
    bound = Solution.load(path).upper
    for policy in ("one-object", "threshold:0.9"):
        assert result[policy]["optimal_value"] == bound
        assert result[policy]["mean"] > 0.0
        assert result[policy]["confidence_limit"] > result[policy]["mean"]
    text = output("compare", model, *options)
    assert re.search(r"^ +loses at most +\d+\.\d+ ± \d", text, re.MULTILINE)
    assert re.search(r"^Certified: the bound of the optimal value", text, re.MULTILINE)
    refused = command("evaluate", model, "--policy", "threshold", "--threshold", "0.9", "--reference", path)
    assert re.search(r"cannot value actions.*`compare` bounds", refused.stderr)
