"""`beltsort run` with a node of ROS 2."""

from pathlib import Path

import pytest

from beltsort.cli import exit_codes, main
from tests.cli.cells import cell_file
from tests.cli.conftest import folder, trained

__all__ = ["folder", "trained"]

pytestmark = pytest.mark.process


def ros2_file(folder: Path, table: str) -> str:
    return cell_file(folder, ("[planner]", f"[ros2]\n{table}\n[planner]"))


def test_a_run_without_its_node_goes_on_and_says_so_once(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", ros2_file(folder, 'python = "no/python"'), "--objects", "1"]) == 0
    said = capsys.readouterr().err
    assert said.count("no longer published on ROS 2") == 1
    assert str(folder / "cell" / "no" / "python") in said


@pytest.mark.parametrize("table", ['name = "a b"', 'frame = ""', "domain_id = 300", 'nmae = "a"'])
def test_wrong_options_are_told_before_anything_moves(
    folder: Path, table: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", ros2_file(folder, table), "--objects", "1"]) == exit_codes.WRONG
    key = table.split()[0]
    assert f"ros2: {key}" in capsys.readouterr().err.replace("ros2.", "ros2: ")
    assert not (folder / "runs").exists()
