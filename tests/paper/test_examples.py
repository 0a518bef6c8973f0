"""The examples run, as a reader would run them."""

import os
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
