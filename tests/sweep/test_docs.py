"""The sweep files in docs/sweep.md can be run, and make the grids that it says."""

import re
import shutil
from pathlib import Path

import pytest

from tests.sweep.test_file import PAPER, load

DOCS = Path(__file__).parent.parent.parent / "docs" / "sweep.md"
FILES = re.findall(r"```toml\n(.*?)```", DOCS.read_text(), flags=re.DOTALL)


@pytest.mark.parametrize(("number", "rows"), [(0, 72), (1, 160)])
def test_the_examples(tmp_path: Path, number: int, rows: int) -> None:
    shutil.copy(PAPER, tmp_path / "model.json")
    assert len(load(tmp_path, FILES[number]).points) == rows
