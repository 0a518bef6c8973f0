"""The paper's experiments, by one call or piece by piece.

`reproduce` runs everything and writes a folder; `redraw` draws the figures again from the numbers in it. In
a notebook the pieces are there too: `run_experiments` returns rows with one number per batch, `plain_table`
their means and standard errors, each figure is a function of these that returns a matplotlib figure, and
`all_claims` returns which claims hold.

References
----------
A. Mezei, L. Tamas, L. Busoniu, "Sorting objects from a conveyor belt using active perception with a POMDP
model", European Control Conference 2019.

Examples
--------
One point of Fig. 5, with labels drawn from the paper's tables:

>>> from beltsort import paper
>>> model = paper.PAPER.model.replace(r_min=5.0)
>>> point = paper.label_point(paper.QUICK, 0, model, paper.FOUR, batches=20)
>>> (row,) = paper.plain_table([point | paper.simulate_labels(point)])
>>> row["policy"], row["r_min"], 15 < row["steps"] < 25
('DESPOT (recommended)', 5.0, True)
"""

from beltsort.paper.claims import all_claims, claims
from beltsort.paper.curves import (
    accuracy_figure,
    beyond_figure,
    bounds_figure,
    moving_figure,
    one_against_two_figure,
    steps_figure,
)
from beltsort.paper.design import FULL, QUICK, Design
from beltsort.paper.figures import single_position_run
from beltsort.paper.instances import FOUR, OBJECTS, PAPER, TWO, Instance, Objects
from beltsort.paper.labels import label_point, label_points, simulate_labels
from beltsort.paper.moving import moving_points, moving_table, sort_moving
from beltsort.paper.optimum import bound_optimum, losses_table
from beltsort.paper.outcomes import only, plain_table, select
from beltsort.paper.outline import THE_PAPER, Outline
from beltsort.paper.reproduction import Redrawn, Reproduction, redraw, reproduce
from beltsort.paper.run import Results, cell_of, run_experiments
from beltsort.paper.scans import PreparedCell, scan_points, sort_scans
from beltsort.paper.setup_figures import clouds_figure, propagated, propagation_figure, reached_sphere
from beltsort.paper.statistics import ClaimResult, Conclusion, Estimate, difference, mean, saving, slope
from beltsort.paper.study import Study, own_study, papers_study

__all__ = [
    "FOUR",
    "FULL",
    "OBJECTS",
    "PAPER",
    "QUICK",
    "THE_PAPER",
    "TWO",
    "ClaimResult",
    "Conclusion",
    "Design",
    "Estimate",
    "Instance",
    "Objects",
    "Outline",
    "PreparedCell",
    "Redrawn",
    "Reproduction",
    "Results",
    "Study",
    "accuracy_figure",
    "all_claims",
    "beyond_figure",
    "bound_optimum",
    "bounds_figure",
    "cell_of",
    "claims",
    "clouds_figure",
    "difference",
    "label_point",
    "label_points",
    "losses_table",
    "mean",
    "moving_figure",
    "moving_points",
    "moving_table",
    "one_against_two_figure",
    "only",
    "own_study",
    "papers_study",
    "plain_table",
    "propagated",
    "propagation_figure",
    "reached_sphere",
    "redraw",
    "reproduce",
    "run_experiments",
    "saving",
    "scan_points",
    "select",
    "simulate_labels",
    "single_position_run",
    "slope",
    "sort_moving",
    "sort_scans",
    "steps_figure",
]
