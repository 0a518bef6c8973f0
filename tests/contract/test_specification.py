"""docs/fieldbus.md says what the code does."""

import re
from enum import IntEnum
from pathlib import Path

import pytest

from beltsort.drivers.fieldbus.wire import EXPLANATIONS, Phase, Reason, Verb
from beltsort.drivers.opcua.diversion_nodes import DIVERSION_NODES
from beltsort.drivers.opcua.nodes import REPLY, REQUEST

PAGE = (Path(__file__).parents[2] / "docs" / "fieldbus.md").read_text()


@pytest.mark.parametrize("kind", [Verb, Phase, Reason])
def test_the_page_has_the_numbers_of_the_code(kind: type[IntEnum]) -> None:
    rows = {
        name: int(number) for name, number in re.findall(r"^\| `([A-Z_]+)` \| (\d+) \|", PAGE, re.MULTILINE)
    }
    assert {member.name: rows.get(member.name) for member in kind if member.name != "NONE"} == {
        member.name: member.value for member in kind if member.name != "NONE"
    }


def test_the_page_has_every_node() -> None:
    for name in (REQUEST, *REPLY, DIVERSION_NODES.request, *DIVERSION_NODES.reply):
        assert f"`{name}`" in PAGE


def test_every_reason_is_explained() -> None:
    assert set(EXPLANATIONS) == set(Reason)
