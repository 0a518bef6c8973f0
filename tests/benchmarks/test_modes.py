"""The benchmark of tables with modes: what it collects and what it says."""

import json
from pathlib import Path

import numpy as np
import pytest

from beltsort.sim import CellConfig
from beltsort.sim.prepare import prepare
from benchmarks.modes.__main__ import main
from benchmarks.modes.collect import RUN_LENGTH, SimulatedLooks, collect
from benchmarks.modes.measure import confidence_levels, repeated

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def looks() -> SimulatedLooks:
    return collect(prepare().database, CellConfig(), objects=RUN_LENGTH)


def test_labels_are_the_nearest_class(looks: SimulatedLooks) -> None:
    found = np.isfinite(looks.distances).all(axis=-1)
    assert found.mean() > 0.9
    np.testing.assert_array_equal(looks.labels[found], looks.distances[found].argmin(axis=-1))
    assert (looks.labels[~found] == -1).all()
    assert (looks.labels == looks.true[:, None, None, None]).mean() > 0.5


def test_what_is_saved_is_loaded(looks: SimulatedLooks, tmp_path: Path) -> None:
    looks.save(tmp_path / "looks.npz")
    loaded = SimulatedLooks.load(tmp_path / "looks.npz")
    for name, values in vars(looks).items():
        np.testing.assert_array_equal(getattr(loaded, name), values)


def test_half_of_the_labels_are_confident(looks: SimulatedLooks) -> None:
    labels = confidence_levels(looks, 2, slice(None))
    found = labels[labels != -1]
    assert (found % 2).mean() == pytest.approx(0.5, abs=0.01)
    np.testing.assert_array_equal(found // 2, looks.labels[labels != -1])
    assert repeated(looks, labels, 8).counts().sum() == len(found)


def test_the_benchmark_as_json(
    looks: SimulatedLooks, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    looks.save(tmp_path / "looks.npz")
    assert main([str(tmp_path / "looks.npz"), "--objects", "12", "--modes", "2", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert len({(row["labels"], row["candidate"]) for row in rows}) == len(rows) == 8
    assert all(row["looks"] == [4, 8, 12] and min(row["log_loss"]) > 0.0 for row in rows)
