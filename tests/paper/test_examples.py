"""The examples run, as a reader would run them."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.process

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples"
SAYS = {
    "01_own_classes_from_meshes": "views of cap, pyramid",
    "02_own_tables_from_csv": "first: Move(viewpoint=1)",
    "03_own_policy": "correct: 9",
    "04_comparing_planners": "the best possible value is between",
    "05_exporting_to_pomdp": "discount: 0.95",
    "06_replaying_a_bag": "p3: object, object",
    "07_pieces_of_the_paper": "saved: ",
    "08_classes_in_bins": "steps on bins, as a multiple of those merged by hand: 0.9",
}


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.py")))
def test_example(name: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(FOLDER / f"{name}.py")],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert SAYS.get(name, "") in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_the_plant(tmp_path: Path) -> None:
    """Six classes, three bins, a manual one, and a classifier of one's own, from meshes to sorted objects."""
    folder = tmp_path / "plant"
    shutil.copytree(
        FOLDER / "plant", folder, ignore=shutil.ignore_patterns("meshes", "*.npz", "*.json", "runs")
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    for command in (
        ["make_plant.py", "--training", "1", "--objects", "4"],
        ["-m", "beltsort", "run", "plant.toml", "--json"],
    ):
        objects = ["--objects", "2"] if "run" in command else []
        done = subprocess.run(
            [sys.executable, *command, *objects], cwd=folder, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert len(result["decisions"]) + len(result["skipped"]) == 2
    assert len(result["confusion"]) == 4
    assert set(result["purity"]) == {"metal", "plastic", "fibre", "by hand"}
    assert {decision["decided"] for decision in result["decisions"]} <= set(result["purity"])
