"""The paper's experiments in seconds: the smallest design from which every figure can be drawn."""

import sys
from dataclasses import replace
from pathlib import Path

import beltsort
from beltsort.models import simulated
from beltsort.paper import QUICK, Instance, PreparedCell, Results, run_experiments

SEED = 3
TINY = replace(
    QUICK,
    r_min=(1.0, 50.0),
    r_min_scans=(1.0, 50.0),
    r_min_discounts=(5.0, 50.0),
    r_min_optimum=(5.0, 50.0),
    batches=4,
    batches_cell=3,
    batches_discounts=3,
    batches_beyond=3,
    batches_tuning=5,
    batches_optimum=3,
    batches_scans=1,
    trials=8,
    seconds_optimum=0.1,
    bonuses=(0.0, 1.0),
    positions=(1, 3),
    sharpness=(1.0, 2.0),
    arrivals=(0.0, 1.0),
    speeds=(10.0, 60.0),
    runs_moving=2,
)


def run(model: Path, database: Path, folder: Path, workers: int) -> Results:
    tables = beltsort.SortingModel.load(model)
    cell = PreparedCell(Instance("cell", tables), database, Instance("cell_modes", simulated()))
    return run_experiments(cell, folder, TINY, seed=SEED, workers=workers)


if __name__ == "__main__":
    run(Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]), workers=2)
