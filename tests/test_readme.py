"""README's examples and the output it shows are true."""

import doctest
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from tests.docs.excerpts import shows

pytestmark = pytest.mark.process

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"


def test_python_examples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    results = doctest.testfile(str(README), module_relative=False)
    assert results.attempted > 5
    assert results.failed == 0


def test_explanation() -> None:
    before, shown = next(
        pair for pair in pairwise(README.read_text().split("```")) if pair[1].startswith("\nDeciding")
    )
    arguments = re.findall(r"`beltsort (plan .*)`", before)[-1].split()
    done = subprocess.run(
        [sys.executable, "-m", "beltsort", *arguments], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.endswith(f"\n{shown}")


def test_demo_output(tmp_path: Path) -> None:
    shown = next(block for block in README.read_text().split("```")[1::2] if "observation tables" in block)
    done = subprocess.run(
        [sys.executable, "-m", "beltsort", "demo"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    printed = done.stdout.splitlines()
    assert shows(shown.strip().splitlines(), printed), f"README shows {shown}, printed is {done.stdout}"
