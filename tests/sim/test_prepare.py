"""Classifier and tables of a cell: what comes with the package, and the cache."""

import json
from dataclasses import dataclass, field, replace
from importlib.resources import as_file
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort.cli import main
from beltsort.errors import CellError
from beltsort.perception import NearestNeighbour, PerceptionConfig
from beltsort.sim import CellConfig
from beltsort.sim import prepare as module
from beltsort.sim.collect import collect_scans, collect_training
from beltsort.sim.config import TABLE_OBJECTS
from beltsort.sim.prepare import (
    ABOUT,
    PACKAGED,
    PIPELINE,
    SCANS,
    SEED,
    Prepared,
    Recipe,
    load,
    prepare,
    read_scans,
)
from beltsort.tables import count
from beltsort.tables.scans import looks
from beltsort.util.processes import Progress

pytestmark = pytest.mark.process


@dataclass
class Stages:
    """Notes the stages that are started."""

    started: list[str] = field(default_factory=list)

    def __call__(self, name: str) -> Progress:
        self.started.append(name)
        return lambda _done, _total: None


SMALL = Recipe(training_objects=1, table_objects=1)


def small(cache: Path, config: CellConfig | None = None) -> Prepared:
    return prepare(replace(SMALL, config=config or CellConfig()), cache=cache)


def packaged(recipe: Recipe | None = None) -> Prepared | None:
    with as_file(PACKAGED) as folder:
        return load(folder, recipe or Recipe(), "package")


REMEDY = (
    "if results are meant to change, raise PIPELINE in beltsort/sim/prepare.py and run "
    "beltsort prepare -o beltsort/models/simulated_cell"
)


def test_the_default_cell_comes_with_the_package(tmp_path: Path) -> None:
    prepared = prepare(cache=tmp_path / "never made")
    assert prepared.source == "package", REMEDY
    assert not list(tmp_path.iterdir())
    assert prepared.database.classes == CellConfig().classes
    rows = prepared.counts.counts.sum(axis=-1) + prepared.counts.missed
    np.testing.assert_array_equal(rows, TABLE_OBJECTS)
    about = json.loads((PACKAGED / ABOUT).read_text())
    assert (about["pipeline"], about["seed"]) == (PIPELINE, SEED)
    assert about["versions"].keys() >= {"beltsort", "open3d", "numpy"}
    assert packaged(Recipe(training_objects=3)) is None


def test_the_code_still_makes_the_classifier_of_the_package() -> None:
    """Another processor may round another way, which puts a point into a neighbouring bin."""
    stored = prepare().database
    made = collect_training(objects=1, seed=SEED)
    n = made.labels.size
    np.testing.assert_array_equal(made.labels, stored.labels[:n], err_msg=REMEDY)
    moved = np.abs(made.descriptors - stored.descriptors[:n]).max(axis=1)
    assert moved.max() <= 2.0, f"percent of the points in one bin; {REMEDY}"
    assert np.median(moved) <= 0.5, REMEDY


def test_the_code_still_gives_the_labels_of_the_package() -> None:
    made = collect_scans(prepare().database, objects=1, seed=SEED)
    with as_file(PACKAGED / SCANS) as path:
        stored = read_scans(path)[: len(made)]
    assert [scan.true for scan in made] == [scan.true for scan in stored], REMEDY
    both = [(a.observed, b.observed) for a, b in zip(made, stored, strict=True)]
    labels = [pair for made_now, packaged in both for pair in zip(made_now, packaged, strict=True)]
    assert sum(a == b for a, b in labels) >= 0.95 * len(labels), REMEDY


@pytest.fixture
def made_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have a few entries of the package made in place of new ones: the cache does not care."""
    packaged = prepare().database
    few = NearestNeighbour.train(packaged.descriptors[:9], packaged.labels[:9], packaged.classes)
    with as_file(PACKAGED / SCANS) as path:
        scans = read_scans(path)[:8]
    monkeypatch.setattr(module, "collect_training", lambda *_, **__: few)
    monkeypatch.setattr(module, "collect_scans", lambda *_, **__: scans)


@pytest.mark.usefixtures("made_at_once")
def test_cache_is_used_mended_and_keyed_by_the_recipe(tmp_path: Path) -> None:
    made = small(tmp_path)
    again = small(tmp_path)
    assert (made.source, again.source) == ("made", "cache")
    for stored in ("counts", "missed", "agree", "pairs"):
        np.testing.assert_array_equal(getattr(made.counts, stored), getattr(again.counts, stored))
    np.testing.assert_array_equal(made.database.descriptors, again.database.descriptors)

    (scans,) = tmp_path.glob(f"*/{SCANS}")
    scans.write_bytes(scans.read_bytes()[:100])
    mended = small(tmp_path)
    assert mended.source == "made"
    np.testing.assert_array_equal(made.counts.counts, mended.counts.counts)
    assert len(list(tmp_path.iterdir())) == 1, "no half-written entry stays"

    assert small(tmp_path, CellConfig(size_spread=0.1)).source == "made"


def test_what_changes_results_changes_the_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = tmp_path / "mesh.ply"
    keys = [
        Recipe().key(),
        Recipe(CellConfig(size_spread=0.1)).key(),
        Recipe(perception=PerceptionConfig(voxel=0.003)).key(),
        Recipe(training_objects=39).key(),
        Recipe(table_objects=99).key(),
    ]
    for content in ("a", "b"):
        mesh.write_text(content)
        keys.append(Recipe(CellConfig(meshes={"standard": str(mesh)})).key())
    monkeypatch.setattr(module, "PIPELINE", PIPELINE + 1)
    keys.append(Recipe().key())
    assert len(set(keys)) == len(keys)


def test_the_command_makes_what_prepare_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "made"
    command = ["prepare", "-o", str(folder), "--objects-per-row", "1", "--training-objects", "1"]
    assert main([*command, "--json"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert "training 100 %" in err
    assert "tables 100 %" in err
    assert set(told["bytes"]) == {"about.json", "classifier.npz", "scans.npz"}
    assert told["key"] == SMALL.key()
    made = load(folder, SMALL, "cache")
    assert made is not None
    np.testing.assert_array_equal(
        made.database.descriptors, collect_training(objects=1, seed=SEED).descriptors
    )
    again = count(looks(collect_scans(made.database, objects=1, seed=SEED)), 2, 3, 4)
    np.testing.assert_array_equal(made.counts.counts, again.counts)


def test_the_command_replaces_no_other_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "thesis").write_text("years of work")
    assert main(["prepare", "-o", str(tmp_path)]) == 2
    assert str(tmp_path) in capsys.readouterr().err
    assert (tmp_path / "thesis").read_text() == "years of work"


@pytest.mark.parametrize(
    ("settings", "error", "said"),
    [
        ({"training_objects": 0}, beltsort.ArgumentError, "training_objects is 0, expected at least 1"),
        ({"table_objects": -1}, beltsort.ArgumentError, "table_objects is -1, expected at least 1"),
        ({"config": CellConfig(meshes={"standard": "/no.ply"})}, CellError, "mesh file /no.ply"),
        ({"config": CellConfig(meshes={"standard": "/"})}, CellError, "mesh file /:"),
        ({"cache": Path(__file__)}, beltsort.BeltsortError, r"folder .* cannot be written"),
        ({"cache": Path(__file__) / "in"}, beltsort.BeltsortError, r"folder .* cannot be written"),
    ],
)
def test_what_cannot_succeed_is_refused_before_the_work(
    settings: dict[str, Any], error: type[Exception], said: str, tmp_path: Path
) -> None:
    stages = Stages()
    cache = settings.pop("cache", tmp_path)
    with pytest.raises(error, match=said):
        prepare(replace(SMALL, **settings), cache=cache, progress=stages)
    assert stages.started == []
    assert list(tmp_path.iterdir()) == []
