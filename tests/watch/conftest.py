"""Finished runs, made once."""

from pathlib import Path

import pytest

from tests.sorting.moving.runs import plant, sort
from tests.watch.runs import sort_bulbs


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run of six bulbs at two positions, in which one scan was unusable."""
    folder = tmp_path_factory.mktemp("finished")
    sort_bulbs(folder, unusable=(3,))
    return folder


@pytest.fixture(scope="session")
def four(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run at four positions, with bins that are not the classes."""
    folder = tmp_path_factory.mktemp("four")
    sort_bulbs(folder, positions=4, two_bins=True, max_looks=3)
    return folder


@pytest.fixture(scope="session")
def moving(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run of twelve cups, one of them empty."""
    folder = tmp_path_factory.mktemp("moving")
    sort(folder, plant())
    return folder
