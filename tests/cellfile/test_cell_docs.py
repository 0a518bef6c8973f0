"""docs/cell.md tells the truth, and all of it."""

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.cellfile import sections
from beltsort.cellfile.composed import compose
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.moving import Moving
from beltsort.cellfile.registry import BUILT_IN
from beltsort.cellfile.validation import Section, validated
from beltsort.perception.named_classifier import as_classifier
from beltsort.testing.fault_kinds import Fault


def is_section(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, Section)


TEXT = (Path(__file__).parents[2] / "docs" / "cell.md").read_text()
PYTHON = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
TOML = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
SECTIONS: list[type[Section]] = [
    CellDescription,
    Moving,
    *(kind for kind in vars(sections).values() if is_section(kind)),
]


def test_the_example_of_a_real_cell_can_be_read_and_composed(tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    path.write_text(TOML[0])
    description = CellDescription.load(path)
    assert description.bin_numbers == (3, 4, 9)
    assert compose(description, live=False, say=print).reject_bin == 2


def test_the_example_of_a_classifier_classifies() -> None:
    (code,) = (block for block in PYTHON if "probabilities" in block)
    defined: dict[str, Any] = {}
    exec(code, defined)
    classifier = as_classifier(defined["CLASSIFIER"])
    assert list(classifier.classes) == tomllib.loads(TOML[0])["classes"]
    assert classifier.classify(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]), np.ones(3)).label == 1


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
