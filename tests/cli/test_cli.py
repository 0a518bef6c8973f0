"""The real command, run as a user runs it."""

import json
import os
import re
import signal
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

import beltsort

from .running import PAPER, command, json_of, output

pytestmark = pytest.mark.process

QUICK = ["--batches", "20"]


def test_info() -> None:
    facts = json_of("info")
    assert facts["beltsort"] == beltsort.__version__
    assert facts["build_profile"] in {"debug", "release"}
    assert facts["packages"]["numpy"] == version("numpy")
    assert facts["threads"] >= 1
    assert re.search(rf"numpy +{re.escape(version('numpy'))}\n", output("info"))


def test_a_reader_that_leaves_is_no_error() -> None:
    """As `head` does once it has its lines."""
    ours, theirs = os.pipe()
    os.close(ours)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "beltsort", "plan", "paper", "--trials", "2"],
            stdout=theirs,
            stderr=subprocess.PIPE,
            text=True,
        )
    finally:
        os.close(theirs)
    assert (done.returncode, done.stderr) == (128 + signal.SIGPIPE, "")


def test_plan_says_the_same_as_the_library() -> None:
    model = beltsort.SortingModel.load(PAPER)
    belief = beltsort.Belief(model)
    belief.observe(0, [1, None])
    belief.observe(2, [1, 0])
    expected = beltsort.Despot(model, trials=30, scenarios=100, seed=4).plan(belief, 2)
    result = json_of(
        *("plan", PAPER, "--observe", "p1=livarno,-", "--observe", "2=1,elongated"),
        *("--trials", "30", "--scenarios", "100", "--seed", "4"),
    )
    assert result["viewpoint"] == "p3"
    assert [list(row.values()) for row in result["belief"]] == belief.probabilities.tolist()
    assert list(result["belief"][0]) == model.classes
    assert result["action"] == {"decide": "livarno"}
    assert [entry["value"] for entry in result["values"]] == list(expected.values.values())
    assert result["values"][-1]["action"] == {"move": "p3"}
    assert (result["lower"], result["upper"]) == (expected.lower, expected.upper)
    assert result["certified_upper"] == expected.certified_upper
    assert result["trials"] == 30


def test_plan_for_a_belt_that_ends() -> None:
    model = beltsort.SortingModel.load(PAPER)
    expected = beltsort.Despot(model, trials=30).plan(beltsort.Belief(model, remaining=1), 0)
    result = json_of("plan", PAPER, "--remaining", "1", "--trials", "30")
    assert [entry["value"] for entry in result["values"]] == list(expected.values.values())
    assert result["certified_upper"] < model.r_max


def test_plan_with_a_solution_says_what_its_bounds_leave_open(tmp_path: Path) -> None:
    model, file = beltsort.SortingModel.load(PAPER), str(tmp_path / "solution")
    solution = beltsort.solve(model, seconds=1)
    solution.save(file)
    expected = beltsort.Despot(model, trials=20, solution=solution).plan(beltsort.Belief(model))
    arguments = ("plan", PAPER, "--trials", "20", "--solution", file)
    result = json_of(*arguments)
    assert result["certified_upper"] == expected.certified_upper
    assert [entry["value"] for entry in result["values"]] == list(expected.values.values())
    loss = result["certified_upper"] - result["certified_lower"]
    assert f"loses at most {loss:.3f} against an optimal one." in output(*arguments)


def test_plan_in_words() -> None:
    text = output("plan", PAPER, "--viewpoint", "p2", "--trials", "20")
    assert "The camera stands at p2." in text
    assert "Next: move to p3 and scan." in text
    assert re.search(r"position +elongated +livarno +mushroom +standard\n +1 +0.250 +0.250", text)
    assert re.search(r"sort as standard +-\d+\.\d", text)
    assert "20 trials" in text


@pytest.mark.parametrize(
    ("options", "policy"),
    [
        (["threshold", "--threshold", "0.9"], lambda m: beltsort.Threshold(m, 0.9)),
        (
            ["information-gain", "--threshold", "0.9", "--positions-counted", "2"],
            lambda m: beltsort.InformationGain(m, 0.9, 2),
        ),
        (["despot", "--trials", "2"], lambda m: beltsort.Despot(m, trials=2)),
    ],
)
def test_evaluate_says_the_same_as_the_library(options: list[str], policy: Any) -> None:
    model = beltsort.SortingModel.load(PAPER)
    expected = beltsort.evaluate(model, policy(model), batches=20, batch_size=5, seed=3)
    result = json_of(
        *(
            "evaluate",
            PAPER,
            "--policy",
            *options,
            *QUICK,
            "--batch-size",
            "5",
            "--seed",
            "3",
            "--threads",
            "2",
        )
    )
    assert result["summary"] == expected.summary()
    assert result["policy"] == options[0]


def test_evaluate_in_words_names_its_command_line() -> None:
    arguments = ["evaluate", PAPER, "--policy", "threshold", "--threshold", "0.9", *QUICK]
    text = output(*arguments)
    assert f"Made by: beltsort evaluate {PAPER} --policy threshold" in text
    assert re.search(r"steps +\d+\.\d+ +± \d", text)
    assert "expected discounted returns" in text


def test_evaluate_draws_from_the_classes_named() -> None:
    options = ["evaluate", PAPER, "--policy", "threshold", "--threshold", "0.9", "--batches", "1"]
    summary = json_of(*options, "--true-classes", "livarno,3")["summary"]
    assert "expected_discounted_returns" not in summary
    assert summary["steps"]["standard_error"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["plan", "absent.json"], r"absent\.json\b.*there is no such file"),
        (["plan", PAPER, "--viewpoint", "q3"], r"viewpoint 'q3'.*'p3'.*\bp1, p2, p3\b"),
        (["plan", PAPER, "--viewpoint", "3"], r"viewpoint '3'.*\bp1, p2, p3\b.*\b0\b.*\b2\b"),
        (["plan", PAPER, "--observe", "p1=livrano,-"], "label 'livrano'.*'livarno'"),
        (["plan", PAPER, "--observe", "p1"], r"--observe p1\b.*\bVIEWPOINT=LABEL,LABEL\b"),
        (["plan", PAPER, "--observe", "p1=livarno"], r"\b1 labels\b.*\b2 positions\b"),
        (["plan", PAPER, "--trials", "0"], r"\btrials\b.*\b0\b.*\b1\b"),
        (["evaluate", PAPER, "--policy", "threshold"], r"--policy threshold\b.*--threshold\b.*\b0\.94\b"),
        (
            ["evaluate", PAPER, "--policy", "despot", "--threshold", "0.9"],
            r"--threshold\b.*--policy despot\b",
        ),
        (["evaluate", PAPER, "--policy", "despot", "--batches", "0"], r"\bbatches\b.*\b0\b.*\b1\b"),
    ],
)
def test_errors_are_one_line(arguments: list[str], message: str) -> None:
    done = command(*arguments, "--json")
    assert done.returncode == 2
    assert done.stdout == ""
    assert re.fullmatch(rf"beltsort: error: .*{message}.*\n", done.stderr)


def test_a_model_file_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "model.json").write_text('{"classes": ["a",\n"b"], "viewpoint": []}')
    done = command("plan", str(tmp_path / "model.json"))
    assert done.returncode == 2
    assert '"viewpoints"?' in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "arguments", [[], ["sort"], ["plan"], ["plan", PAPER, "--trials", "1", "--seconds", "1"], ["info", "-x"]]
)
def test_wrong_usage(arguments: list[str]) -> None:
    done = command(*arguments)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("usage: beltsort")


def test_version_and_help() -> None:
    assert output("--version") == f"beltsort {beltsort.__version__}\n"
    for name in ("info", "plan", "evaluate"):
        assert re.search(rf"^ +{name} +\w", output("--help"), re.MULTILINE)


SAYING_WHEN_IT_PLANS = """
import sys
from beltsort.cli import main

def watch(frame, event, called):
    if event == "c_call" and called.__name__ in ("plan", "evaluate"):
        sys.setprofile(None)
        print("now", flush=True)

sys.setprofile(watch)
sys.exit(main())
"""


@pytest.mark.parametrize(
    "arguments",
    [
        ["evaluate", PAPER, "--policy", "despot", "--batches", "10000000"],
        ["plan", PAPER, "--seconds", "100000"],
        ["plan", PAPER, "--trials", "1000000000"],
    ],
)
def test_control_c(arguments: list[str]) -> None:
    script = [sys.executable, "-c", SAYING_WHEN_IT_PLANS, *arguments]
    with subprocess.Popen(script, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "now\n"
            process.send_signal(signal.SIGINT)
            told, errors = process.communicate()
        finally:
            process.kill()
    assert process.returncode == 130
    assert told == errors == ""


def test_solve_brackets_the_optimum() -> None:
    for seconds in ("1", "4", "16", "64"):
        solved = command("solve", PAPER, "--positions", "1", "--seconds", seconds, "--json")
        bounds = json.loads(solved.stdout)  # standard error tells of the progress
        assert bounds["lower"] < 17.5
        assert bounds["upper"] > 17.4955
        if bounds["upper"] - bounds["lower"] < 0.1:
            return
    pytest.fail("the bounds do not tighten")


def test_solve_refuses_no_time() -> None:
    assert command("solve", PAPER, "--seconds", "0").returncode == 2


def test_solve_saves_the_solution(tmp_path: Path) -> None:
    path = tmp_path / "paper.solution"
    result = command("solve", PAPER, "--seconds", "1", "--json", "-o", str(path))
    assert json.loads(result.stdout)["lower"] == beltsort.Solution.load(path).lower
    assert str(path) in result.stderr


def test_solve_refuses_a_path_before_it_solves(tmp_path: Path) -> None:
    for path, reason in [
        (tmp_path, rf"{re.escape(str(tmp_path))} .*\bdirectory\b"),
        (tmp_path / "missing" / "file", r"missing/file\b.*\bdirectory\b.*/missing\b"),
    ]:
        result = command("solve", PAPER, "--seconds", "3600", "-o", str(path))
        assert result.returncode == 2
        assert re.search(reason, result.stderr)
