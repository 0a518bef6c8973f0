"""The examples in the docstrings are true."""

import doctest
import pkgutil
from importlib import import_module

import pytest

import beltsort

FOUND = pkgutil.walk_packages(beltsort.__path__, "beltsort.")
MODULES = [module.name for module in FOUND if not module.name.endswith(("__main__", "._core"))]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    assert doctest.testmod(import_module(name)).failed == 0


def test_every_room_is_walked_through() -> None:
    assert len({name.split(".")[1] for name in MODULES}) > 15
    assert "beltsort.sorting.command" in MODULES
