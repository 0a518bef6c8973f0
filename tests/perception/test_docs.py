"""The examples in the docstrings are true."""

import doctest
import pkgutil
from importlib import import_module

import pytest

from beltsort import perception

MODULES = [module.name for module in pkgutil.walk_packages(perception.__path__, "beltsort.perception.")]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    assert doctest.testmod(import_module(name)).failed == 0
