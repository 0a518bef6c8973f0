"""The examples in the docstrings are true."""

import doctest
import pkgutil
from importlib import import_module

import pytest

from beltsort import viewpoints

MODULES = [module.name for module in pkgutil.iter_modules(viewpoints.__path__, "beltsort.viewpoints.")]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    assert doctest.testmod(import_module(name)).failed == 0
