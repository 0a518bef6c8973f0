"""The main job as a user runs it: real processes, real scans, the classifier and tables of the package."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from beltsort.sorting.belief_figure import belief_over_time
from beltsort.sorting.journal import read_journal

pytestmark = pytest.mark.process


def demo(folder: Path, cache: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "beltsort", "demo", *arguments],
        cwd=folder,
        env={**os.environ, "XDG_CACHE_HOME": str(cache)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a cache that the first run fills."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def first(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("first")
    done = demo(folder, cache, "--json", "--seed", "5")
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_json_tells_of_every_decision(first: tuple[Path, dict[str, Any]]) -> None:
    _, result = first
    decisions = result["decisions"]
    assert [d["object"] for d in decisions] == list(range(10))
    assert {d["true"] for d in decisions} <= {"elongated", "livarno"}
    assert result["correct"] == sum(d["true"] == d["decided"] for d in decisions)
    assert result["steps"] >= 10
    assert set(result["seconds"]) == {"training", "tables", "planner", "sorting", "picture"}
    assert result["model"]["counts"] is not None


def test_run_folder_holds_journal_model_and_picture(first: tuple[Path, dict[str, Any]]) -> None:
    folder, result = first
    run = folder / result["folder"]
    entries = read_journal(run / "journal.sqlite")
    assert entries[-1].data == {"reason": "done"}
    moves = sum(e.kind == "scan" for e in entries)
    assert moves + len(result["decisions"]) == result["steps"]
    assert json.loads((run / "model.json").read_text()) == result["model"]
    assert (run / "belief.png").read_bytes().startswith(b"\x89PNG")
    beliefs, decisions, _ = belief_over_time(entries)
    assert len(beliefs) == result["steps"] + 1
    assert [name for _, name in decisions] == [d["decided"] for d in result["decisions"]]


def test_same_seed_same_run_and_plain_lines_without_a_terminal(
    first: tuple[Path, dict[str, Any]], cache: Path, tmp_path: Path
) -> None:
    _, before = first
    done = demo(tmp_path, cache, "--seed", "5")
    assert done.returncode == 0, done.stderr
    assert "from the package: " in done.stdout
    assert f"{before['correct']} of 10 right in {before['steps']} steps" in done.stdout
    decided = re.findall(r"object +\d+ +decide (\w+)", done.stdout)
    assert decided == [d["decided"] for d in before["decisions"]]


def test_other_seed_other_objects(first: tuple[Path, dict[str, Any]], cache: Path, tmp_path: Path) -> None:
    other = json.loads(demo(tmp_path, cache, "--json", "--seed", "6").stdout)
    assert [d["true"] for d in other["decisions"]] != [d["true"] for d in first[1]["decisions"]]


def test_interrupt_leaves_a_complete_journal(cache: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "beltsort", "demo"]
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache)}
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True) as demo:
        assert demo.stdout is not None
        next(line for line in demo.stdout if line.startswith("object"))
        demo.send_signal(signal.SIGINT)
        assert demo.wait(timeout=60) == 130
    (journal,) = tmp_path.glob("runs/*/journal.sqlite")
    last = read_journal(journal)[-1]
    assert last.kind == "end"
    assert "KeyboardInterrupt" in last.data["reason"]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [(["--seed", "-1"], "seed is -1"), (["--objects-per-row", "0"], "objects is 0")],
)
def test_bad_arguments_are_one_line(
    arguments: list[str], complaint: str, cache: Path, tmp_path: Path
) -> None:
    done = demo(tmp_path, cache, *arguments)
    assert done.returncode == 2
    assert complaint in done.stderr
    assert len(done.stderr.splitlines()) == 1, "refused before anything is started"
    assert not list(tmp_path.glob("runs/*"))


def test_unwritable_run_folder_is_named(tmp_path: Path, cache: Path) -> None:
    (tmp_path / "runs").write_text("a file where the folder should be")
    done = demo(tmp_path, cache)
    assert done.returncode == 2
    assert "run folder runs" in done.stderr
    assert len(done.stderr.splitlines()) == 1
