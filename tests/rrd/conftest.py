"""A run of the simulated cell that is recorded, once."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from beltsort.sim.demo import DemoResult, run_demo
from beltsort.sim.prepare import Recipe, prepare

SEED = 3


@dataclass(frozen=True)
class RecordedRun:
    """A run and its recording."""

    result: DemoResult
    rrd: Path
    complaints: list[str]


def record(folder: Path) -> RecordedRun:
    complaints: list[str] = []
    rrd = folder / "run.rrd"
    result = run_demo(prepare(Recipe()), SEED, folder, rrd=rrd, say=complaints.append)
    return RecordedRun(result, rrd, complaints)


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    return record(tmp_path_factory.mktemp("recorded"))


@pytest.fixture
def home(tmp_path: Path) -> Mapping[str, str]:
    """Return an environment in which rerun sends no usage statistics, with settings of its own."""
    settings, data = tmp_path / "config" / "rerun" / "analytics.json", tmp_path / "data"
    settings.parent.mkdir(parents=True)
    plain = {
        "analytics_enabled": False,
        "analytics_id": "none",
        "metadata": {},
        "config_file_path": str(settings),
        "data_dir_path": str(data),
    }
    settings.write_text(json.dumps(plain))
    places = {"HOME": tmp_path, "XDG_CONFIG_HOME": tmp_path / "config", "XDG_DATA_HOME": data}
    return {**os.environ, **{name: str(path) for name, path in places.items()}}
