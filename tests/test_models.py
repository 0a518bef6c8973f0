"""The models that come with the package."""

from beltsort import SortingModel, models

from .core.models import PAPER


def test_the_papers_instance() -> None:
    assert models.paper() == SortingModel.load(PAPER)
