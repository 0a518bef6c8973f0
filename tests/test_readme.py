"""README's examples and the output it shows are true."""

import doctest
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

pytestmark = pytest.mark.process

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"


def test_python_examples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    results = doctest.testfile(str(README), module_relative=False)
    assert results.attempted > 5
    assert results.failed == 0


NUMBER = re.compile(r"\d+(?:\.\d+)?")


def alike(shown: str, printed: str) -> bool:
    """Whether two lines agree, but for what another processor's rounding may change."""

    def form(line: str) -> str:
        return NUMBER.sub("N", line.replace("from the cache", "estimated now"))

    def near(a: str, b: str) -> bool:
        return abs(float(a) - float(b)) <= (0.1 if "." in a else 0.3 * float(a))

    numbers = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=False)
    return form(shown) == form(printed) and all(near(a, b) for a, b in numbers)


def shows(shown: list[str], printed: list[str]) -> bool:
    """Whether the shown lines are the printed ones, in order, with `...` for one or more left out."""
    if not shown:
        return not printed
    first, *rest = shown
    if first == "...":
        return any(shows(rest, printed[left_out:]) for left_out in range(1, len(printed) + 1))
    return bool(printed) and alike(first, printed[0]) and shows(rest, printed[1:])


PRINTED = ["a 1", "b 2", "c 3", "d 4"]


@pytest.mark.parametrize(
    "shown",
    [
        ["a 1", "b 2", "c 3", "d 4"],
        ["a 1", "...", "d 4"],
        ["...", "b 2", "...", "d 4"],
        ["a 1", "b 2", "..."],
    ],
)
def test_excerpts(shown: list[str]) -> None:
    assert shows(shown, PRINTED)


@pytest.mark.parametrize(
    "shown",
    [
        ["a 1", "c 3", "d 4"],
        ["a 1", "...", "b 2", "..."],
        ["...", "c 3", "...", "b 2", "..."],
        ["b 2", "..."],
        ["a 1", "...", "c 3"],
        ["a 1", "b 2", "c 3", "d 4", "..."],
        ["...", "a 1", "b 2", "c 3", "d 4"],
        ["a 1", "...", "c 9", "..."],
    ],
)
def test_wrong_excerpts(shown: list[str]) -> None:
    assert not shows(shown, PRINTED)


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
