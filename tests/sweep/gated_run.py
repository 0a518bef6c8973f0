"""Two processes, four points that are free and two that wait: `python -m tests.sweep.gated_run FOLDER`."""

import sys
from pathlib import Path

from beltsort.sweep.engine import run_points
from tests.sweep.tasks import noted

FREE, ALL = 4, 6


def run(folder: Path) -> list[int]:
    common = {"notes": str(folder / "notes")}
    waiting = {**common, "gate": str(folder / "gate")}
    points = [{"x": x, **(common if x < FREE else waiting)} for x in range(ALL)]
    return [row["square"] for row in run_points(noted, points, folder / "store", workers=2)]


if __name__ == "__main__":
    print(run(Path(sys.argv[1])))
