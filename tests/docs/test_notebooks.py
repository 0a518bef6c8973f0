"""The notebooks run, and print what their outputs say."""

from pathlib import Path

import nbformat
import pytest

from tests.docs.excerpts import shows
from tests.docs.notebooks import NOTEBOOKS, executed, pictures, texts

pytestmark = [pytest.mark.process, pytest.mark.slow]
MOST_BYTES = 200_000


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_outputs(path: Path) -> None:
    stored = [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]
    now = [cell for cell in executed(path).cells if cell.cell_type == "code"]
    for old, new in zip(stored, now, strict=True):
        assert shows(texts(old), texts(new)), f"run python -m tests.docs.notebooks: {old.source}"
        assert pictures(old) == pictures(new)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_small(path: Path) -> None:
    assert path.stat().st_size < MOST_BYTES
    assert any(map(texts, nbformat.read(path, as_version=4).cells))
