"""beltsort export."""

import re
from pathlib import Path

import pytest

from beltsort import SortingModel

from .running import PAPER, command, json_of, output

pytestmark = pytest.mark.slow


def test_export_writes_what_the_library_writes(tmp_path: Path) -> None:
    SortingModel.load(PAPER).to_pomdp(tmp_path / "expected.pomdp")
    expected = (tmp_path / "expected.pomdp").read_bytes()
    file = tmp_path / "paper.pomdp"
    assert json_of("export", PAPER, str(file)) == {"file": str(file), "bytes": len(expected)}
    assert file.read_bytes() == expected
    assert output("export", PAPER, str(file)) == f"{file}: {len(expected)} bytes\n"


def test_another_format_is_refused(tmp_path: Path) -> None:
    done = command("export", PAPER, str(tmp_path / "paper.pomdpx"))
    assert done.returncode == 2
    assert re.search(r"paper\.pomdpx\b.*\.pomdp\b", done.stderr)
    assert not list(tmp_path.iterdir())
