"""One call that runs the experiments and writes every figure, table and the report, and one that redraws."""

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from beltsort.paper.circumstances import Circumstances
from beltsort.paper.design import FULL, Design
from beltsort.paper.figures import Picture, draw_all
from beltsort.paper.files import Numbers
from beltsort.paper.report import write_report
from beltsort.paper.run import STORE, Results, cell_of, run_experiments
from beltsort.paper.scans import PreparedCell
from beltsort.paper.study import Study
from beltsort.sim.demo import check_seed
from beltsort.sim.prepare import Prepared, StageProgress
from beltsort.sorting.runs import make_folder


@dataclass(frozen=True, eq=False)
class Redrawn:
    """Figures and report, and the numbers that they show.

    Attributes
    ----------
    numbers
        What they show.
    pictures
        The figures; each is there as PNG, SVG and PDF.
    report
        The HTML file.
    """

    numbers: Numbers
    pictures: list[Picture]
    report: Path


@dataclass(frozen=True, eq=False)
class Reproduction(Redrawn):
    """The files that were written, and the numbers in them.

    Attributes
    ----------
    results
        All rows.
    tables
        The CSV files.
    """

    results: Results
    tables: list[Path]


def reproduce(
    prepared: Prepared | None,
    folder: Path,
    design: Design | Study = FULL,
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
        Classifier and tables of the default simulated cell: `beltsort.sim.prepare.prepare()`. None for
        a study of one's own, from `own_study`.
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
    cell = None if prepared is None else cell_of(prepared, folder / STORE)
    results = run_experiments(cell, folder, design, seed=seed, workers=workers, stage=stage)
    about = Circumstances.now(command, seed, results.study, results.seconds)
    numbers = Numbers.of(results, None if prepared is None else prepared.counts, about)
    tables = numbers.write(folder)
    began = perf_counter()
    drawn = _draw(cell, numbers, folder)
    results.seconds["figures"] = perf_counter() - began
    return Reproduction(numbers, drawn.pictures, drawn.report, results, tables)


def redraw(prepared: Prepared | None, source: Path, folder: Path) -> Redrawn:
    """Draw the figures and write the report from the files of an earlier reproduction.

    Figures 1 to 3 show no numbers of these files: they are computed again.

    Parameters
    ----------
    prepared
        As in `reproduce`; for Fig. 3. None leaves figures 1 to 3 out.
    source
        Folder of the reproduction.
    folder
        Where figures and report are written; may be the same.

    Raises
    ------
    ArgumentError
        If the source has no such files.
    JournalError
        If the folder cannot be made.
    """
    numbers = Numbers.read(source)
    make_folder(folder)
    with TemporaryDirectory() as scratch:
        return _draw(None if prepared is None else cell_of(prepared, Path(scratch)), numbers, folder)


def _draw(cell: PreparedCell | None, numbers: Numbers, folder: Path) -> Redrawn:
    pictures = draw_all(numbers, cell, folder)
    return Redrawn(numbers, pictures, write_report(numbers, pictures, folder))
