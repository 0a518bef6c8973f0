import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort.cell.simulated import CellConfig
from beltsort.errors import CellError
from beltsort.perception import PerceptionConfig
from beltsort.tables import prepare as module
from beltsort.tables.prepare import Prepared, prepare
from beltsort.tables.processes import Progress


@dataclass
class Stages:
    """Notes the stages that are started."""

    started: list[str] = field(default_factory=list)

    def __call__(self, name: str) -> Progress:
        self.started.append(name)
        return lambda _done, _total: None


def small(cache: Path, config: CellConfig | None = None) -> Prepared:
    return prepare(config, training_objects=1, table_objects=1, cache=cache)


def test_cache_is_used_mended_and_keyed_by_the_configuration(tmp_path: Path) -> None:
    made = small(tmp_path)
    again = small(tmp_path)
    assert (made.cached, again.cached) == (False, True)
    np.testing.assert_array_equal(made.counts.counts, again.counts.counts)
    np.testing.assert_array_equal(made.database.descriptors, again.database.descriptors)

    (counts,) = tmp_path.glob("*/counts.npz")
    counts.write_bytes(counts.read_bytes()[:100])
    mended = small(tmp_path)
    assert not mended.cached
    np.testing.assert_array_equal(made.counts.counts, mended.counts.counts)
    assert len(list(tmp_path.iterdir())) == 1, "no half-written entry stays"

    assert not small(tmp_path, CellConfig(size_spread=0.1)).cached


def key() -> str:
    return module._key(CellConfig(), PerceptionConfig(), 1, 1)


@pytest.mark.parametrize(
    ("file", "matters"),
    [
        ("geometry.py", True),
        ("cell/simulated/sensor.py", True),
        ("perception/vfh.py", True),
        ("tables/collect.py", True),
        ("sorter.py", False),
    ],
)
def test_the_code_that_made_an_entry_names_it(
    file: str, matters: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = key()
    copy = tmp_path / "beltsort"
    shutil.copytree(module.PACKAGE, copy, ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    monkeypatch.setattr(module, "PACKAGE", copy)
    assert key() == before, "where the package lies does not matter"
    with (copy / file).open("a") as source:
        source.write("# changed\n")
    assert (key() != before) == matters


@pytest.mark.parametrize(
    ("settings", "error", "said"),
    [
        ({"training_objects": 0}, beltsort.ArgumentError, "training_objects is 0, expected at least 1"),
        ({"table_objects": -1}, beltsort.ArgumentError, "table_objects is -1, expected at least 1"),
        ({"config": CellConfig(meshes={"standard": "/no.ply"})}, CellError, "mesh file /no.ply"),
        ({"config": CellConfig(meshes={"standard": "/"})}, CellError, "mesh file /:"),
        ({"cache": Path(__file__)}, beltsort.BeltsortError, r"cache folder .* cannot be written"),
        ({"cache": Path(__file__) / "in"}, beltsort.BeltsortError, r"cache folder .* cannot be written"),
    ],
)
def test_what_cannot_succeed_is_refused_before_the_work(
    settings: dict[str, Any], error: type[Exception], said: str, tmp_path: Path
) -> None:
    stages = Stages()
    with pytest.raises(error, match=said):
        prepare(
            **{"training_objects": 1, "table_objects": 1, "cache": tmp_path, "progress": stages, **settings}
        )
    assert stages.started == []
    assert list(tmp_path.iterdir()) == []
