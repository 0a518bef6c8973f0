"""The classifier that a cell file names."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.run import CellRun, open_run
from beltsort.cli import main
from beltsort.errors import DatabaseError
from beltsort.sim import CellConfig
from tests.cellfile.cell_files import described
from tests.cli.cells import PREPARE

CODE = f"""
import numpy as np

class ByHeight:
    def __init__(self, classes={CellConfig().classes}):
        self.classes = classes

    def probabilities(self, points, camera):
        height = float(np.clip(np.ptp(points[:, 2]) / 0.1, 0.0, 1.0))
        return np.array([height, 1.0 - height, 0.0, 0.0])

class Short(ByHeight):
    def probabilities(self, points, camera):
        return [0.5, 0.5]

CLASSIFIER, SHORT, TURNED = ByHeight(), Short(), ByHeight({CellConfig().classes[::-1]})
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return the folder of a cell file, with a model and a user's module."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "toy_classifier.py").write_text(CODE)
    p_obs = np.tile(0.1 + 0.6 * np.eye(4), (2, 3, 1, 1))
    beltsort.SortingModel(CellConfig().classes, ["p1", "p2", "p3"], p_obs).save(tmp_path / "model.json")
    yield tmp_path
    sys.modules.pop("toy_classifier", None)


def opened(folder: Path, classifier: str) -> CellRun:
    files = f'model = "model.json"\nclassifier = "{classifier}"'
    return open_run(described(folder, (PREPARE, files)), folder / "runs", live=False, say=print)


def test_a_classifier_of_ones_own(folder: Path) -> None:
    classifier = opened(folder, "toy_classifier:CLASSIFIER").classifier
    assert tuple(classifier.classes) == CellConfig().classes
    assert classifier.classify(np.eye(3), np.ones(3)).label == 0


@pytest.mark.parametrize(
    ("classifier", "said"),
    [
        ("toy_missing:CLASSIFIER", r"'toy_missing:CLASSIFIER'.*No module named 'toy_missing'"),
        ("toy_classifier:MISSING", r"'toy_classifier:MISSING'.*'MISSING'"),
        ("classifier.npz", r"classifier\.npz\b.*No such file"),
    ],
)
def test_a_classifier_that_is_not_there(folder: Path, classifier: str, said: str) -> None:
    with pytest.raises(DatabaseError, match=said):
        opened(folder, classifier)


def test_its_classes_are_the_cell_s_in_order(folder: Path) -> None:
    with pytest.raises(CellFileError, match=r"classifier: .*\['standard', .*\['elongated', "):
        opened(folder, "toy_classifier:TURNED")


@pytest.mark.slow
def test_a_run_with_a_classifier_of_ones_own(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    opened(folder, "toy_classifier:CLASSIFIER")  # writes the cell file
    assert main(["run", str(folder / "cell.toml"), "--objects", "1"]) == 0
    assert "1 sorted in " in capsys.readouterr().out
    opened(folder, "toy_classifier:SHORT")
    assert main(["run", str(folder / "cell.toml"), "--objects", "1"]) == 2
    assert re.search(r"\bShort\b.*\bshape \(2,\).*\(4,\)", capsys.readouterr().err)
