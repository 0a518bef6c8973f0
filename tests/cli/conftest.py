"""A folder in which a cell can run."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_training


@pytest.fixture(scope="session")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a classifier and a model."""
    folder = tmp_path_factory.mktemp("trained")
    config = CellConfig()
    collect_training(config, objects=1, seed=3, workers=1).save(folder / "classifier.npz")
    p_obs = np.tile(0.1 + 0.6 * np.eye(4), (2, 3, 1, 1))
    beltsort.SortingModel(config.classes, ["p1", "p2", "p3"], p_obs).save(folder / "model.json")
    return folder


@pytest.fixture
def folder(trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working folder, with classifier and model in a folder of the cell."""
    shutil.copytree(trained, tmp_path / "cell")
    monkeypatch.chdir(tmp_path)
    return tmp_path
