"""Every public name of the packages that users import has a page in the reference."""

import re
from importlib import import_module

import pytest

from tests.docs.pages import ROOT

NO_PAGE = {"__version__", "models", "Act", "TrackingEvent"}  # a string, a module, type aliases
LISTED = {
    name.rpartition(".")[2]
    for page in (ROOT / "docs" / "api").glob("*.md")
    for name in re.findall(r"^   ([A-Za-z_][\w.]*)$", page.read_text(), re.MULTILINE)
}


@pytest.mark.parametrize(
    "package", ["", ".models", ".perception", ".tables", ".cell", ".sim", ".tracking", ".errors"]
)
def test_public_names(package: str) -> None:
    module = import_module(f"beltsort{package}")
    names = getattr(module, "__all__", None) or [
        name for name, thing in vars(module).items() if getattr(thing, "__module__", "") == module.__name__
    ]
    assert len(names) > 2
    assert set(names) - NO_PAGE <= LISTED
