"""README's examples and the output it shows are true, in an empty folder."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import ROOT, Block, PageRun, blocks_of
from tests.ports import HeldPort

pytestmark = [pytest.mark.process, pytest.mark.slow]
README = ROOT / "README.md"
BY_TEST = "by the test of this section"


def test_its_blocks(tmp_path: Path) -> None:
    PageRun(README, tmp_path).run()


def test_what_is_run_and_shown() -> None:
    blocks = blocks_of(README)
    left_out = [block.comments["not run"] for block in blocks if "not run" in block.comments]
    assert [reason for reason in left_out if reason != BY_TEST] == [
        "installs",
        "three quarters of an hour on two cores; with --quick six minutes",
    ]
    assert sum("output" in block.comments for block in blocks) == 2
    assert {block.language for block in blocks} == {"sh", "python", "text"}


def test_the_cell_of_the_example(tmp_path: Path) -> None:
    prepared, served, sorted_by = (
        block for block in blocks_of(README) if block.comments.get("not run") == BY_TEST
    )
    shell(prepared, tmp_path)
    with HeldPort() as held:
        port = str(held.number)
        cell = tmp_path / "cell.toml"
        cell.write_text(cell.read_text().replace("4840", port))
        server = subprocess.Popen(
            [sys.executable, *served.code.replace("4840", port).split()[1:]],
            cwd=tmp_path,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            assert server.stdout is not None
            assert json.loads(server.stdout.readline())
            printed = shell(sorted_by, tmp_path)
        finally:
            server.communicate(timeout=60)  # it ends with its standard input
    assert "everything is within the limits" in printed
    assert printed.count("10 sorted in ") == 2  # the dry run, too


def shell(block: Block, folder: Path) -> str:
    """Run a block and return what it prints."""
    run = PageRun(README, folder)
    run.shell(block)
    return run.printed
