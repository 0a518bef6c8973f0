"""`beltsort check`, with a classifier of a few objects and a model made up for it."""

import re
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.cli import main
from tests.cli.cells import cell_file
from tests.cli.running import result_of

pytestmark = pytest.mark.process


def test_check_tells_in_words_and_exits_with_1_beyond_a_limit(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", cell_file(folder)]) == 0
    said = capsys.readouterr().out
    assert "everything is within the limits" in said
    assert "limits (the file's [check]): belt_angle 2, belt_height 25" in said
    assert re.search(r"model model\.json:\nExpected, per object\b.*\bright\b", said)
    strict = cell_file(folder, ("belt_angle = 2.0", "belt_angle = 0.01"))
    assert main(["check", strict]) == 1
    assert "0.01 (check.belt_angle)" in capsys.readouterr().out
    assert main(["check", strict, "--json"]) == 1
    result = result_of(capsys)
    assert result["exceeded"]
    assert result["expected"]["max_looks"] == 60
    assert result["limits"]["belt_angle"] == 0.01
    assert [view["viewpoint"] for view in result["viewpoints"]] == ["p1", "p2", "p3"]
    assert {row["act"] for row in result["seconds"]} == {"health", "move_to", "scan"}


def test_check_finds_what_a_run_would_refuse(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    order = ('"mushroom", "standard"', '"standard", "mushroom"')
    assert main(["check", cell_file(folder, order)]) == 1
    assert re.search(r"classifier: .*list them in the classifier's order", capsys.readouterr().out)
    (folder / "cell" / "classifier.npz").unlink()
    assert main(["check", cell_file(folder)]) == 1
    assert "cell/classifier.npz" in capsys.readouterr().out


def test_check_warns_of_a_belt_that_cannot_be_sorted_and_exits_with_0(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = folder / "cell" / "model.json"
    chance = beltsort.SortingModel.load(model)
    chance.replace(p_obs=np.full(chance.p_obs.shape, 0.25)).save(model)
    assert main(["check", cell_file(folder), "--json"]) == 0
    expected = result_of(capsys)["expected"]
    assert any("cannot be told apart" in warning for warning in expected["warnings"])
    assert "manual bin" in expected["remedies"][0]["change"]
    model.unlink()
    assert main(["check", cell_file(folder), "--json"]) == 0
    assert result_of(capsys)["expected"] is None
