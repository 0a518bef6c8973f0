"""Runs without a fixed end, in the cell file and in the simulated cell."""

from pathlib import Path

import pytest

from beltsort.cell.commands import CommandError
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.simulated import SimulatedOptions, make
from beltsort.cellfile.validation import validated
from tests.cellfile.cell_files import changed, described

UNLIMITED = ("\nobjects = 10\n", '\nobjects = "unlimited"\n')
DRAWN = 'draw_from = ["elongated", "livarno"]'


def true_classes(description: CellDescription, number: int) -> list[int | None]:
    cell = make(validated(SimulatedOptions, description.options_of("arm")), description)
    return [cell.true_class(n) for n in range(number)]


def test_the_simulated_belt_goes_on_with_the_same_objects(tmp_path: Path) -> None:
    ten = true_classes(described(tmp_path), 12)
    unlimited = true_classes(described(tmp_path, UNLIMITED), 200)
    assert ten == [*unlimited[:10], None, None]
    assert set(unlimited) == {0, 1}
    given = described(tmp_path, UNLIMITED, (DRAWN, 'true_labels = ["mushroom", "-"]'))
    assert true_classes(given, 5) == [2, None, None, None, None]
    some_empty = true_classes(described(tmp_path, UNLIMITED, (DRAWN, f"{DRAWN}\nempty = 0.5")), 200)
    assert set(some_empty) == {None, 0, 1}
    assert 70 < some_empty.count(None) < 130


def test_objects_that_have_passed_are_forgotten(tmp_path: Path) -> None:
    description = described(tmp_path, UNLIMITED)
    cell = make(validated(SimulatedOptions, description.options_of("arm")), description)
    for n in range(0, 60, 20):
        cell.advance_to(n, f"advance-{n}")
        cell.scan(not_before=0.0)
        assert min(cell._world._objects) >= n
    with pytest.raises(CommandError, match=r"\bany later one\b"):
        cell.advance_to(3, "back")


@pytest.mark.parametrize("value", ['"endless"', "0", "-1", "1.5"])
def test_other_numbers_of_objects(tmp_path: Path, value: str) -> None:
    with pytest.raises(CellFileError, match=r'^objects: .*"unlimited"'):
        CellDescription.load(changed(tmp_path, ("\nobjects = 10\n", f"\nobjects = {value}\n")))


def test_a_belt_that_ends_has_a_number_of_objects(tmp_path: Path) -> None:
    with pytest.raises(CellFileError, match=r"^belt_ends: .*\bunlimited\b"):
        CellDescription.load(
            changed(tmp_path, ("\nobjects = 10\n", '\nobjects = "unlimited"\nbelt_ends = true\n'))
        )
