"""One call that runs the experiments and writes every figure, table and the report."""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from beltsort.paper.design import FULL, Design
from beltsort.paper.figures import Picture, draw_all
from beltsort.paper.files import write_tables
from beltsort.paper.report import Circumstances, write_report
from beltsort.paper.run import STORE, Results, cell_of, run_experiments
from beltsort.sim.demo import check_seed
from beltsort.sim.prepare import Prepared, StageProgress
from beltsort.sorting.runs import make_folder


@dataclass(frozen=True, eq=False)
class Reproduction:
    """The files that were written, and the numbers in them.

    Attributes
    ----------
    results
        All rows.
    pictures
        The figures; each is there as PNG and SVG.
    tables
        The CSV files.
    report
        The HTML file.
    """

    results: Results
    pictures: list[Picture]
    tables: list[Path]
    report: Path


def reproduce(
    prepared: Prepared,
    folder: Path,
    design: Design = FULL,
    *,
    seed: int = 0,
    workers: int | None = None,
    stage: StageProgress | None = None,
    command: str = "beltsort.paper.reproduce",
) -> Reproduction:
    """Run the paper's experiments and write figures, tables and the report into a folder.

    An interrupted run resumes if this is called again with the same folder.

    Parameters
    ----------
    prepared
        Classifier and tables of the default simulated cell: `beltsort.sim.prepare.prepare()`.
    folder
        Made if missing.
    design, seed, workers, stage
        As in `run_experiments`.
    command
        Command line for the report.

    Raises
    ------
    ArgumentError
        If the seed is negative or `workers` is below 1.
    JournalError
        If the folder cannot be made.
    """
    check_seed(seed)
    make_folder(folder)
    cell = cell_of(prepared, folder / STORE)
    results = run_experiments(cell, folder, design, seed=seed, workers=workers, stage=stage)
    began = perf_counter()
    tables = write_tables(results, prepared.counts, folder)
    pictures = draw_all(results, design, seed, folder)
    results.seconds["figures"] = perf_counter() - began
    of = Circumstances(command, seed, design)
    return Reproduction(
        results, pictures, tables, write_report(results, prepared.counts, pictures, of, folder)
    )
