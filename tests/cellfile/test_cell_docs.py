"""docs/cell.md tells the truth, and all of it."""

import re
import tomllib
from pathlib import Path

import pytest

from beltsort.cellfile import sections
from beltsort.cellfile.composed import compose
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.registry import BUILT_IN
from beltsort.cellfile.validation import Section, validated
from beltsort.testing.fault_kinds import Fault


def is_section(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, Section)


TEXT = (Path(__file__).parents[2] / "docs" / "cell.md").read_text()
TOML = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
SECTIONS: list[type[Section]] = [
    CellDescription,
    *(kind for kind in vars(sections).values() if is_section(kind)),
]


def test_the_example_of_a_real_cell_can_be_read_and_composed(tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    path.write_text(TOML[0])
    description = CellDescription.load(path)
    assert description.bin_numbers == (3, 4, 9)
    assert compose(description, live=False, say=print).reject_bin == 2


def test_the_example_of_faults_can_be_read() -> None:
    faults = validated(sections.FaultSection, tomllib.loads(TOML[-1])["faults"])
    assert faults.plan().schedule == {("sort", 3): Fault.FULL_BIN}


@pytest.mark.parametrize("section", SECTIONS)
def test_every_key_is_told(section: type[Section]) -> None:
    keys = set(section.model_fields) - {"viewpoints", "arm", "camera", "belt", "sorter", "backends"}
    tables = set(re.findall(r"`\[+(\w+)\]+`", TEXT))
    assert {key for key in keys if f"`{key}`" not in TEXT} <= tables


def test_every_back_end_and_every_fault_is_told() -> None:
    assert all(f"| `{name}` |" in TEXT for name in BUILT_IN)
    assert all(f"`{kind.value}`" in TEXT for kind in Fault)
