import pytest

from beltsort import SortingModel

from .models import PAPER


@pytest.fixture(scope="session")
def paper() -> SortingModel:
    return SortingModel.load(PAPER)
