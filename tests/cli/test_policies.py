"""Policies by the same words in every command, those of one's own included."""

import sys
from pathlib import Path

import pytest

from beltsort.sorting.audit import entries_of
from beltsort.sorting.entries import Chosen

from .cells import cell_file
from .running import PAPER, command, json_of, output

OWN = """
import beltsort

def careful(model):
    return beltsort.Threshold(model, 0.99)

class Blind:
    def act(self, belief, viewpoint):
        return beltsort.Decide(belief.most_likely(0)[0])

BLIND = Blind()
"""
FEW = ("--batches", "3")


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder with a module of policies."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.delitem(sys.modules, "own_policies", raising=False)
    (tmp_path / "own_policies.py").write_text(OWN)


@pytest.mark.parametrize(
    ("word", "options"),
    [
        ("despot:20", ["--policy", "despot", "--trials", "20"]),
        ("threshold:0.9", ["--policy", "threshold", "--threshold", "0.9"]),
        (
            "information-gain:0.9:2",
            ["--policy", "information-gain", "--threshold", "0.9", "--positions-counted", "2"],
        ),
    ],
)
def test_a_word_says_what_options_say(word: str, options: list[str]) -> None:
    by_word = json_of("evaluate", PAPER, "--policy", word, *FEW)
    assert by_word["summary"] == json_of("evaluate", PAPER, *options, *FEW)["summary"]


@pytest.mark.parametrize("word", ["one-object", "look-ahead"])
def test_evaluate_takes_every_word(word: str) -> None:
    assert json_of("evaluate", PAPER, "--policy", word, *FEW)["policy"] == word


@pytest.mark.usefixtures("own")
def test_policies_of_ones_own() -> None:
    careful = json_of("evaluate", PAPER, "--policy", "own_policies:careful", *FEW)
    assert careful["summary"] == json_of("evaluate", PAPER, "--policy", "threshold:0.99", *FEW)["summary"]
    words = ["own_policies:careful", "own_policies:BLIND", "own_policies:Missing"]
    assert words[1] in output("compare", PAPER, "--policies", *words[:2], *FEW)
    refused = command("compare", PAPER, "--policies", words[0], words[2], *FEW)
    assert refused.returncode == 2
    assert "the policy 'own_policies:Missing' cannot be loaded" in refused.stderr


@pytest.mark.usefixtures("own")
def test_sweep_takes_them_too(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    (tmp_path / "sweep.toml").write_text(
        f'level = "tables"\nseeds = 1\n[model]\nfile = "{PAPER}"\n'
        '[planner]\npolicy = ["own_policies:careful", "threshold:0.99"]\n[tables]\nbatches = 2\n'
    )
    done = command("sweep", "sweep.toml", "--workers", "1", "--json")
    assert done.returncode == 0, done.stderr


@pytest.mark.process
def test_run_takes_a_policy_and_resumes_with_it(folder: Path) -> None:
    cell = cell_file(folder)
    assert command("run", cell, "--objects", "2", "--policy", "threshold:0.5").returncode == 0
    (run,) = (folder / "runs").iterdir()
    assert (run / "policy.txt").read_text() == "threshold:0.5\n"
    chosen = [entry.content for entry in entries_of(run) if entry.kind == "plan"]
    assert chosen
    assert all(isinstance(content, Chosen) for content in chosen)
    refused = command("run", cell, "--objects", "2", "--policy", "one-object", "--resume", str(run))
    assert refused.returncode == 2
    assert 'the run began with "threshold:0.5"' in refused.stderr
