"""Build a model from your own counts of labels, exported from a spreadsheet as CSV."""

import csv
from io import StringIO

import numpy as np

import beltsort

COUNTS = """position,viewpoint,true,observed,objects
1,left,nut,nut,70
1,left,nut,bolt,30
1,left,bolt,nut,20
1,left,bolt,bolt,80
1,right,nut,nut,85
1,right,nut,bolt,15
1,right,bolt,nut,25
1,right,bolt,bolt,75
"""
SMOOTHING = 1.0  # pseudo-count per entry; with a zero, a single label could rule out a class for good


def main() -> None:
    """Read the counts, build the model, ask for the first action."""
    rows = list(csv.DictReader(StringIO(COUNTS)))  # with a file: open("counts.csv")
    positions, viewpoints, classes = (sorted({row[key] for row in rows}) for key in KEYS)
    counts = np.zeros((len(positions), len(viewpoints), len(classes), len(classes)), dtype=int)
    for row in rows:
        true, observed = classes.index(row["true"]), classes.index(row["observed"])
        where = positions.index(row["position"]), viewpoints.index(row["viewpoint"])
        counts[(*where, true, observed)] = int(row["objects"])
    smoothed = counts + SMOOTHING
    p_obs = smoothed / smoothed.sum(axis=-1, keepdims=True)
    model = beltsort.SortingModel(classes, viewpoints, p_obs, counts=counts, smoothing=SMOOTHING)
    plan = beltsort.Despot(model, trials=100).plan(beltsort.Belief(model))
    print(f"first: {plan.action}, worth {max(plan.values.values()):.1f}")


KEYS = ("position", "viewpoint", "true")

if __name__ == "__main__":
    main()
