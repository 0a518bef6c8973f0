"""Tables of moving belts, and cell files with them."""

import sys
from pathlib import Path

import numpy as np
import pytest

from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.ingredients import model_and_classifier
from beltsort.cellfile.sorted_belt import SimulatedBelt, sort_belt
from benchmarks import moving_tables


def test_a_folder_has_what_its_cell_files_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(moving_tables, "OBJECTS", 4)
    monkeypatch.setattr(sys, "argv", ["moving_tables", "--belts", "1", "-o", str(tmp_path / "moving")])
    moving_tables.main()
    for name, modes in (("one_mode", False), ("modes", True), ("standing", False)):
        cell = CellDescription.load(tmp_path / "moving" / f"{name}.toml")
        model, classifier = model_and_classifier(cell, None, None)
        assert (model.positions, model.r_min) == (2, 20)
        assert (max(map(len, model.modes)) > 1) <= modes
        found = sort_belt(SimulatedBelt(cell, "most-urgent:0.8", 2, 5, model, classifier))
        assert found.confusion.sum() + found.missed.sum() <= 2
        assert found.seconds == pytest.approx(2 * 3.0)


def test_looks_are_those_of_the_objects_that_the_belt_carries(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(
        moving_tables.cell_file(tmp_path, tmp_path / "classifier.npz", tmp_path / "model.json"), "utf-8"
    )
    descriptors, labels = moving_tables.described(tmp_path / "cell.toml", 3)
    assert len(descriptors) == len(labels) > moving_tables.OBJECTS
    assert set(labels) == {0, 1, 2, 3}
    np.testing.assert_allclose(np.sum(descriptors, axis=1), np.sum(descriptors[0]), rtol=0.01)
