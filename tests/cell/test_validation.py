"""Plain data made into settings."""

from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import pytest

from beltsort.cell.problems import CellFileError
from beltsort.cell.validation import validated
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
        ({}, ["host: is missing; add it"]),
        ({"host": 3}, ["host: is 3, expected a valid string"]),
        ({"host": "a", "rate": "1"}, ["rate: is '1', expected a valid number"]),
        ({"host": "a", "rate": True}, ["rate: is True, expected a valid number"]),
        ({"host": "a", "rate": 0}, ["rate is 0.0, expected above 0; start from the default"]),
        ({"host": "a", "mode": "fats"}, ["mode: is 'fats', expected 'fast' or 'slow'"]),
        (
            {"host": "a", "nodes": [{"name": "b"}, {"name": "c", "indx": 1}]},
            ["nodes[1].indx: is an unknown key; did you mean 'index'? Known: name, index"],
        ),
        (
            {"host": "a", "kode": "fast"},
            ["kode: is an unknown key; did you mean 'mode'? Known: host, rate, mode, key, nodes, names"],
        ),
        (
            {"host": "a", "rate": "1", "nodes": [{}]},
            ["rate: is '1', expected a valid number", "nodes[0].name: is missing; add it"],
        ),
    ],
)
def test_what_is_wrong_is_told(given: dict[str, object], said: list[str]) -> None:
    with pytest.raises(CellFileError) as error:
        validated(Options, given)
    assert str(error.value).splitlines() == said


def test_long_values_are_cut() -> None:
    with pytest.raises(CellFileError, match=r"host: is \['aaa.*\.\.\., expected a valid string$"):
        validated(Options, {"host": ["a" * 1000]})
