"""Positions of the belt: people read numbers from 1, the belt end; Python and files have indices from 0."""

import re
from pathlib import Path

import pytest

import beltsort
from beltsort.cli import main
from beltsort.models import paper
from beltsort.sorting.entries import Drifted, Started
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry
from beltsort.util.text import position_number

PACKAGE = Path(beltsort.__file__).parent
OWN_NUMBERS = re.compile(r"(\bj|\bposition) \+ 1(\}|\))|position \{(j|position)\}|\[str\(j\),")
"""How a text would number positions without `position_number`."""


def test_one_function_writes_a_position() -> None:
    assert [position_number(index) for index in range(3)] == ["1", "2", "3"]
    for file in PACKAGE.rglob("*.py"):
        assert not OWN_NUMBERS.search(file.read_text()), f"{file}: use position_number"


def rows(text: str) -> list[str]:
    """Return the first column below a header `position`."""
    lines = text.splitlines()
    (start,) = (i for i, line in enumerate(lines) if line.split()[:1] == ["position"])
    return [line.split()[0] for line in lines[start + 1 : start + 3]]


def test_beliefs_are_printed_with_numbers_from_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert rows(repr(beltsort.Belief(paper()))) == ["1", "2"]
    assert main(["plan", "paper", "--trials", "10"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("Belief, position 1 at the belt end:\n")
    assert rows(text) == ["1", "2"]


def test_a_refused_label_names_the_position_from_1() -> None:
    belief = beltsort.Belief(paper(), [[1.0, 0.0, 0.0, 0.0], [0.25] * 4])
    with pytest.raises(
        beltsort.ImpossibleObservationError, match=r"^position 1, viewpoint p1: label mushroom"
    ):
        belief.observe("p1", ["mushroom", "livarno"])


def test_an_index_is_named_as_such() -> None:
    assert beltsort.Belief(paper()).most_likely(0)[1] == 0.25
    with pytest.raises(
        beltsort.ArgumentError, match=r"index 2 of a position is out of range: 0, the belt end, to 1"
    ):
        beltsort.Belief(paper()).most_likely(2)


def test_a_drift_alarm_names_the_position_from_1() -> None:
    formatter = EntryFormatter()
    formatter.format(Entry(1, "", None, Started(run="r", objects=1, model=paper().to_json())))
    text = formatter.format(Entry(2, "", 0, Drifted(0, 2, 100, None)))
    assert text is not None
    assert "labels at position 1 from p3 no longer fit" in text
