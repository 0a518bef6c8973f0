"""The paper's experiments with a model and with policies of one's own; bins are not the classes."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beltsort import ArgumentError, Belief, Decide, Move, SortingModel, evaluate, paper
from beltsort.cli import main
from beltsort.paper import FULL, QUICK, THE_PAPER, own_study, run_experiments
from beltsort.paper.instances import penalty_of, with_penalty
from beltsort.paper.labels import label_points, outcomes_of
from beltsort.paper.policies import INFORMATION_GAIN, POLICIES, PUBLISHED, RECOMMENDED, source_of

REWARD = [[10.0, -40.0, -40.0], [-20.0, 10.0, 10.0], [-3.0, -3.0, -3.0]]
POLICY = """
import beltsort

class Glance:
    def __init__(self, model):
        self.model = model

    def act(self, belief, viewpoint):
        if belief.probabilities[0].max() < 0.7:
            return beltsort.Move(1)
        return beltsort.Decide(int((self.model.reward @ belief.probabilities[0]).argmax()))
"""
TINY = replace(
    QUICK,
    r_min=(5.0, 50.0),
    batches=12,
    batches_tuning=5,
    batches_optimum=3,
    trials=4,
    seconds_optimum=0.1,
)


def model(positions: int = 3, **settings: object) -> SortingModel:
    table = [[0.7, 0.2, 0.1], [0.1, 0.8, 0.1], [0.2, 0.2, 0.6]]
    return SortingModel(
        ["nut", "bolt", "cap"],
        ["left", "right"],
        [[table, table]] * positions,
        bins=["steel", "plastic", "by hand"],
        reward=REWARD,
        **settings,  # type: ignore[arg-type]  # whatever a test sets
    )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(paper, "QUICK", TINY)
    model().save("belt.json")
    (tmp_path / "glancing.py").write_text(POLICY)
    return tmp_path


@pytest.fixture
def few_candidates(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paper.policies, "THRESHOLDS", (0.8, 0.95))


@pytest.mark.slow
@pytest.mark.usefixtures("few_candidates")
def test_a_study_of_ones_own(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["reproduce", "--model", "belt.json", "--policy", "one-object", "--policy", "glancing:Glance"]
    assert main([*words, "--quick", "--workers", "1", "-o", "study", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["figures"] == [
        "figure_4_one_position", "accuracy_3_positions", "figure_6_steps", "figure_7_one_against_two",
        "bounds",
    ]  # fmt: skip
    found = {finding["claim"] for finding in told["findings"]}
    assert {"3 positions need fewer steps", "accuracy grows with r_min, 3 positions"} <= found
    compared = [f for f in told["findings"] if f["claim"].startswith(f"it earns more than {RECOMMENDED}")]
    assert len(compared) == 2 * 2, "each policy, with one and with three positions"

    numbers = paper.files.Numbers.read(Path("study"))
    assert {row["policy"] for row in numbers.labels} == {*POLICIES, "one-object", "glancing:Glance"}
    assert {row["positions"] for row in numbers.labels} == {1, 3}
    assert {row["r_min"] for row in numbers.labels} == {5.0, 40.0, 50.0}, "the model's own and the design's"
    assert {row["positions"] for row in numbers.optimum} == {1}
    page = (folder / "study" / "report.html").read_text()
    assert "The offline solution with 3 positions is left out" in page
    assert "Depth scans" in page
    assert "the paper prints" not in page
    assert not re.search(r"\bnan\b", page)

    assert main(["reproduce", "--from", "study", "-o", "again"]) == 0
    assert (folder / "again" / "report.html").read_text() == page
    assert "3 positions need fewer steps" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.usefixtures("few_candidates")
def test_the_papers_tables_give_the_papers_rows(tmp_path: Path) -> None:
    design = replace(TINY, r_min=(50.0, 500.0), r_min_optimum=(50.0, 500.0))
    study = own_study(paper.PAPER.model, "the paper's tables", design)
    own = run_experiments(None, tmp_path / "own", study, workers=1).labels
    four = replace(THE_PAPER, objects=(paper.FOUR,))
    points = label_points(replace(design, discounts=(0.95,)), 0, [paper.PAPER], four)
    assert len(points) == len(own)
    for point, row in zip(points, own, strict=True):
        assert point["model"] == row["model"]
        assert point["policy"] == row["policy"]
    planned = [pair for pair in zip(points, own, strict=True) if pair[0]["policy"] == RECOMMENDED]
    for point, row in planned:
        assert paper.simulate_labels(point)["steps"] == row["steps"]


def test_a_penalty_changes_losses_in_proportion_and_no_manual_bin() -> None:
    assert penalty_of(model()) == 40.0
    changed = with_penalty(model(), 80.0)
    np.testing.assert_array_equal(changed.reward, [[10, -80, -80], [-40, 10, 10], [-3, -3, -3]])
    with pytest.raises(ArgumentError, match=r"reward below 0"):
        penalty_of(model().replace(reward=[[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.5, 0.5, 0.5]]))


def test_objects_sorted_by_hand_are_neither_right_nor_wrong() -> None:
    class ByHand:
        def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
            return Decide(2)

    sorted_by_hand = model(1)
    row = outcomes_of(sorted_by_hand, evaluate(sorted_by_hand, ByHand(), batches=3, batch_size=10))
    assert row["positives"] == row["negatives"] == [0, 0, 0]


@pytest.mark.parametrize(
    ("policies", "complaint"),
    [
        (["desopt:5"], r"no policy 'desopt:5'; did you mean 'despot'"),
        (["despot:0.1s"], r"plans by the clock.*give trials"),
        (["solution:belt.solution"], r"leave it out"),
        (["one-object", "one-object"], r"name it once"),
        ([INFORMATION_GAIN], r"name it once"),
        (["information-gain:0.9:2"], r"with positions = 1: .*positions = 2"),
        (["glancing:Nothing"], r"Nothing"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_policies_that_cannot_be_compared(policies: list[str], complaint: str) -> None:
    with pytest.raises(ArgumentError, match=complaint):
        own_study(model(), "belt", policies=policies)


def test_what_a_model_does_not_allow_is_left_out_and_said() -> None:
    study = own_study(model(2, information_gain=1.0), "belt", FULL)
    assert PUBLISHED not in study.outline.policies
    assert study.optimum_positions == ()
    said = " ".join(study.outline.left_out)
    assert f"{PUBLISHED} is left out: information_gain is set" in said
    assert "The offline solution with two positions is left out: information_gain is set" in said


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--model", "belt.json", "--positions", "1,4"], "positions are 1, 4; give numbers from 1 to 3"),
        (["--model", "belt.json", "--positions", "few"], "--positions few"),
        (["--model", "belt.json", "--r-min", "0,5"], "r_min contains 0"),
        (["--model", "belt.json", "--r-min", "40"], "r_min is 40 only"),
        (["--model", "blet.json"], "did you mean 'belt.json'"),
        (["--positions", "1"], "add --model or --policy"),
        (["--model", "belt.json", "--from", "study"], "--from runs nothing"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_arguments_are_refused_before_anything_is_done(
    arguments: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["reproduce", "-o", "new", *arguments]) == 2
    assert complaint in capsys.readouterr().err
    assert not Path("new").exists()


def test_another_version_of_a_policy_is_run_again(folder: Path) -> None:
    module = folder / "revised_policy.py"
    module.write_text(POLICY)
    before = source_of("revised_policy:Glance")
    assert source_of("revised_policy:Glance") == before
    module.write_text(POLICY.replace("0.7", "0.8"))
    assert source_of("revised_policy:Glance") != before
    assert source_of("threshold:0.9") is None
