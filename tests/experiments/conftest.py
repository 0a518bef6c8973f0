"""A cell that is trained once, on little, and one tiny reproduction on it."""

from pathlib import Path

import pytest

from beltsort.cell.simulated import CellConfig
from beltsort.experiments.paper import Reproduction, reproduce
from beltsort.tables import collect_counts, collect_training
from beltsort.tables.prepare import Prepared

from .tiny import SEED, TINY


@pytest.fixture(scope="session")
def prepared() -> Prepared:
    database = collect_training(CellConfig(), objects=2, seed=SEED, workers=1)
    counts = collect_counts(database, CellConfig(), objects=1, seed=SEED, workers=1)
    return Prepared(database, counts, objects=1, seconds={}, source="made")


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("reproduction")


@pytest.fixture(scope="session")
def reproduction(prepared: Prepared, folder: Path) -> Reproduction:
    """Made by one process, without interruption."""
    return reproduce(prepared, folder, TINY, seed=SEED, workers=1, command="a test")
