"""What a REPL and a notebook show of estimates and their parts: names, and no arrays."""

import numpy as np

import beltsort
from beltsort.tables import DriftWatch, LabelledScan, LooksAtObject, RepeatedLooks, TableShape, estimate
from beltsort.viewpoints import Sampling, map_viewpoints

SCANS = [LabelledScan(0, (i % 2,), (f"object {i}",), (int(i % 5 > 0) * (i % 2),)) for i in range(20)]
ESTIMATE = estimate(SCANS, ["nut", "<bolt>"], ["above"])


def test_an_estimate_shows_accuracy_by_viewpoint_and_the_largest_error() -> None:
    assert repr(ESTIMATE).splitlines() == [
        "Estimate from 20 scans, share of right labels, mean over the classes",
        "  position  above",
        "  1         0.900",
        f"Largest standard error {ESTIMATE.worst.error:.3f}: position 1, above, true <bolt>, 10 objects.",
    ]
    html = ESTIMATE._repr_html_()
    assert "0.900" in html
    assert "true &lt;bolt&gt;" in html


def test_warnings_are_shown() -> None:
    missing = estimate(SCANS[::2], ["nut", "bolt"], ["above"])
    assert "\nWarning: 1 of 2 table rows have no labelled object" in repr(missing)


def test_counts_looks_and_watches_give_their_sizes() -> None:
    assert repr(ESTIMATE.counts) == (
        "Counts(20 labelled objects, 0 without a label; positions 1, viewpoints 1, classes 2, labels 2)"
    )
    shape = TableShape(positions=1, viewpoints=1, classes=2, labels=2)
    looks = RepeatedLooks.of([LooksAtObject(true=0, looks=((0, 0, 0),) * 50)], shape)
    assert "objects=<shape (50,)>" in repr(looks)
    watch = DriftWatch(ESTIMATE.model)
    watch.observe(beltsort.Belief(ESTIMATE.model), 0, [1])
    assert repr(watch) == "DriftWatch(false_alarm=0.01, 1 look, 0 alarms)"


def test_viewpoints_show_directions_and_costs() -> None:
    views = map_viewpoints(Sampling(count=40), viewpoints=3)
    title, header, *rows = repr(views).splitlines()
    assert title.startswith("ViewpointMap: 3 viewpoints of 40 points, ")
    assert header.split() == ["viewpoint", "azimuth", "elevation", "to", "p1", "to", "p2", "to", "p3"]
    assert [row.split()[0] for row in rows] == list(views.names)
    np.testing.assert_array_equal([[float(x) for x in row.split()[3:]] for row in rows], views.motion_cost)
    assert views._repr_html_().count("<tr") == 4
