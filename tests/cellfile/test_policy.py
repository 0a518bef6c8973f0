"""The policy of a cell file: by a word, of one's own, and the same in a run that is resumed."""

from pathlib import Path

import pytest

import beltsort
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.ingredients import policy_of
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.sections import Planner
from beltsort.models import paper
from beltsort.sorting.runs import POLICY
from tests.cellfile.cell_files import changed

MODEL = paper()
OWN = """
import beltsort

class Careful:
    def __init__(self, model):
        self.policy = beltsort.Threshold(model, 0.99)

    def act(self, belief, viewpoint):
        return self.policy.act(belief, viewpoint)
"""


def described(folder: Path, policy: str | None) -> CellDescription:
    lines = "" if policy is None else f'policy = "{policy}"\n'
    return CellDescription.load(changed(folder, ("trials = 300\n", lines)))


def test_despot_with_the_files_settings_is_the_default(tmp_path: Path) -> None:
    policy, name = policy_of(CellDescription.load(changed(tmp_path)), MODEL, None)
    assert isinstance(policy, beltsort.Despot)
    assert policy.settings["trials"] == 300
    assert name == "despot"


def test_a_policy_by_its_word(tmp_path: Path) -> None:
    policy, name = policy_of(described(tmp_path, "threshold:0.9"), MODEL, None)
    assert isinstance(policy, beltsort.Threshold)
    assert name == "threshold:0.9"


def test_a_policy_of_ones_own_lies_beside_the_cell_file(tmp_path: Path) -> None:
    (tmp_path / "careful_policies.py").write_text(OWN)
    policy, name = policy_of(described(tmp_path, "careful_policies:Careful"), MODEL, None)
    assert type(policy).__name__ == "Careful"
    assert name == "careful_policies:Careful"


def test_a_saved_solution_starts_at_the_cell_files_folder(tmp_path: Path) -> None:
    one = MODEL.with_positions(1)
    beltsort.solve(one, seconds=0.1).save(tmp_path / "one.solution")
    policy, name = policy_of(described(tmp_path, "solution:one.solution"), one, None)
    assert isinstance(policy, beltsort.Solution)
    assert name == f"solution:{tmp_path / 'one.solution'}"


def test_a_resumed_run_keeps_its_policy(tmp_path: Path) -> None:
    run = tmp_path / "run"
    run.mkdir()
    (run / POLICY).write_text("one-object\n")
    policy, name = policy_of(described(tmp_path, None), MODEL, run)
    assert isinstance(policy, beltsort.OneObject)
    assert name == "one-object"
    with pytest.raises(CellFileError, match=r'the run began with "one-object": write policy = "one-object"'):
        policy_of(described(tmp_path, "threshold:0.9"), MODEL, run)


@pytest.mark.parametrize(
    ("policy", "message"),
    [
        ("treshold:0.9", r"planner\.policy.*'treshold:0\.9'; did you mean 'threshold'"),
        ("threshold", r"planner\.policy.*'threshold' is not a valid policy"),
        ("absent_module:Policy", r"planner\.policy.*No module named 'absent_module'"),
        ("math:pi", r"planner\.policy.*3\.14.*expected a method act"),
        ("math:sqrt", r"planner\.policy.*cannot be made: TypeError"),
    ],
)
def test_what_is_no_policy(tmp_path: Path, policy: str, message: str) -> None:
    with pytest.raises(CellFileError, match=message):
        policy_of(described(tmp_path, policy), MODEL, None)


def test_settings_of_despot_are_for_despot() -> None:
    with pytest.raises(ValueError, match=r'policy is "one-object" and trials is 20.*leave trials out'):
        Planner(policy="one-object", trials=20)
