"""Every link from one file of the repository to another leads somewhere, and so does every anchor.

`make docs` checks the site's own links; this is about what a reader of the repository follows.
"""

import re
from pathlib import Path

import pytest

from tests.docs.pages import ROOT

FILES = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "tutorial").glob("*.md")]
MADE_BY_THE_BUILD = ROOT / "docs" / "commands"
"""Pages that exist on the site only; `make docs` checks links to them."""
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ +(.*)$", re.MULTILINE)
CODE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    headings = HEADING.findall(CODE.sub("", page.read_text()))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def is_broken(source: Path, link: str) -> bool:
    path, _, anchor = link.partition("#")
    target = (source.parent / path).resolve() if path else source
    if target.is_relative_to(MADE_BY_THE_BUILD):
        return False
    if not target.exists():
        return True
    return bool(anchor) and anchor not in anchors(target)


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(ROOT)))
def test_links(file: Path) -> None:
    links = LINK.findall(CODE.sub("", file.read_text()))
    local = [link for link in links if "://" not in link]
    assert [link for link in local if is_broken(file, link)] == []


def test_external_links_are_encrypted() -> None:
    """They are not followed: tests need no network."""
    links = {link for file in FILES for link in LINK.findall(file.read_text()) if "://" in link}
    assert links
    assert all(link.startswith("https://") for link in links)


def test_an_anchor_that_is_not_there_is_found() -> None:
    cell = ROOT / "docs" / "cell.md"
    assert not is_broken(cell, "cell.md#your-own-classifier")
    assert is_broken(cell, "cell.md#your-own-camera")
    assert is_broken(cell, "no_such_page.md")
