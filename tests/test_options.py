"""Keywords that a dataclass of options does not have."""

import inspect
from collections.abc import Callable
from typing import Any

import pytest

from beltsort.perception import PerceptionConfig
from beltsort.sim import CellConfig
from beltsort.sorting.rules import Rules
from beltsort.tables import ModeSettings


@pytest.mark.parametrize(
    ("options", "given", "meant"),
    [
        (CellConfig, "clases", "classes"),
        (PerceptionConfig, "voxels", "voxel"),
        (Rules, "max_look", "max_looks"),
        (ModeSettings, "start", "starts"),
    ],
)
def test_an_unknown_keyword_is_told_the_nearest(options: Callable[..., Any], given: str, meant: str) -> None:
    with pytest.raises(TypeError, match=f"{given!r}; did you mean {meant!r}"):
        options(**{given: 1})
    assert meant in inspect.signature(options).parameters
