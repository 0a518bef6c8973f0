"""Plain data made into settings."""

import re
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import pytest

from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.validation import validated
from beltsort.errors import CellError


class Mode(StrEnum):
    FAST = "fast"
    SLOW = "slow"


@dataclass(frozen=True)
class Node:
    name: str
    index: int = 0


@dataclass(frozen=True)
class Options:
    host: str
    rate: float = 1.0
    mode: Mode = Mode.SLOW
    key: Path | None = None
    nodes: tuple[Node, ...] = ()
    names: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.rate <= 0.0:
            raise CellError(f"rate is {self.rate}, expected above 0; start from the default")


def test_plain_data_gets_the_types_of_the_fields() -> None:
    given = {
        "host": "plc",
        "rate": 2,
        "mode": "fast",
        "key": "k.pem",
        "nodes": [{"name": "a"}],
        "names": {"x": 1},
    }
    assert validated(Options, given) == Options("plc", 2.0, Mode.FAST, Path("k.pem"), (Node("a"),), {"x": 1})


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, [r"^host: .*\bmissing\b"]),
        ({"host": 3}, [r"^host: .*\b3\b.*\bstring\b"]),
        ({"host": "a", "rate": "1"}, [r"^rate: .*'1'.*\bnumber\b"]),
        ({"host": "a", "rate": True}, [r"^rate: .*\bTrue\b.*\bnumber\b"]),
        ({"host": "a", "rate": 0}, [r"^rate\b.*\b0\.0\b.*\b0\b"]),
        ({"host": "a", "mode": "fats"}, [r"^mode: .*'fats'.*'fast' or 'slow'"]),
        (
            {"host": "a", "nodes": [{"name": "b"}, {"name": "c", "indx": 1}]},
            [r"^nodes\[1\]\.indx: .*'index'.*\bname, index\b"],
        ),
        (
            {"host": "a", "kode": "fast"},
            [r"^kode: .*'mode'.*\bhost, rate, mode, key, nodes, names\b"],
        ),
        (
            {"host": "a", "rate": "1", "nodes": [{}]},
            [r"^rate: .*'1'.*\bnumber\b", r"^nodes\[0\]\.name: .*\bmissing\b"],
        ),
    ],
)
def test_what_is_wrong_is_told(given: dict[str, object], said: list[str]) -> None:
    with pytest.raises(CellFileError) as error:
        validated(Options, given)
    lines = str(error.value).splitlines()
    assert len(lines) == len(said)
    assert all(re.search(pattern, line) for pattern, line in zip(said, lines, strict=True)), lines


def test_long_values_are_cut() -> None:
    with pytest.raises(CellFileError, match=r"^host: .{,12}\['aaa.{,200}\.\.\..*\bstring\b"):
        validated(Options, {"host": ["a" * 1000]})
