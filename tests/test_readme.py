"""README's examples and the output it shows are true."""

import doctest
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
CLASSES = ("elongated", "livarno", "mushroom", "standard")


def test_python_examples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    results = doctest.testfile(str(README), module_relative=False)
    assert results.attempted > 5
    assert results.failed == 0


def pattern(line: str) -> str:
    """Return a line's form, without the classes and numbers that may differ with the processor's rounding."""
    line = re.sub("|".join(CLASSES), "CLASS", line)
    line = line.replace("from the cache", "estimated now")
    return re.sub(r"\d+(\.\d+)?", "N", line)


def test_demo_output(tmp_path: Path) -> None:
    shown = next(block for block in README.read_text().split("```")[1::2] if "observation tables" in block)
    done = subprocess.run(
        [sys.executable, "-m", "beltsort", "demo"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    lines = done.stdout.splitlines()
    forms = {pattern(line) for line in lines}
    for line in shown.strip().splitlines():
        assert pattern(line) in forms, f"README shows {line!r}"
    correct, objects, steps = map(
        int, re.findall(r"^(\d+) of (\d+) right in (\d+) steps", done.stdout, re.M)[0]
    )
    assert objects == 10
    assert correct >= 8, "README shows a run of at least eight right"
    assert steps <= 60, "README shows a run of at most sixty steps"
