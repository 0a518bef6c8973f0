"""A classifier that is trained once, on little."""

from dataclasses import replace
from pathlib import Path

import pytest

from beltsort.perception import NearestNeighbour
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_training


@pytest.fixture(scope="session")
def config() -> CellConfig:
    """The simulated cell with one viewpoint."""
    config = CellConfig()
    return replace(config, viewpoints=config.viewpoints[1:2])


@pytest.fixture(scope="session")
def database(config: CellConfig) -> NearestNeighbour:
    return collect_training(config, objects=2, seed=3, workers=1)


@pytest.fixture(scope="session")
def database_file(database: NearestNeighbour, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("classifier") / "database.npz"
    database.save(path)
    return path
