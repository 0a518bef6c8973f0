"""A classifier's labels are indices into its own classes: the cell's must be the same, in the same order."""

import pytest

from beltsort.calibration.sorted_runs import sort_many
from beltsort.errors import DatabaseError
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_counts, collect_matches, collect_scans
from beltsort.sim.prepare import prepare

REVERSED = CellConfig(classes=tuple(reversed(CellConfig().classes)))


@pytest.mark.parametrize("collect", [collect_scans, collect_matches, collect_counts])
def test_another_order_is_refused_before_anything_is_scanned(collect: object) -> None:
    assert callable(collect)
    with pytest.raises(DatabaseError, match=r"'elongated', .*the cell's \['standard', .*classifier's order"):
        collect(prepare().database, REVERSED, objects=10**6)


def test_other_classes_are_refused() -> None:
    two = CellConfig(classes=CellConfig().classes[:2])
    with pytest.raises(DatabaseError, match="train a classifier for these classes"):
        collect_scans(prepare().database, two, objects=10**6)


def test_runs_are_not_sorted_with_another_order() -> None:
    prepared = prepare()
    model = prepared.counts.model(CellConfig().classes, ["p1", "p2", "p3"])
    with pytest.raises(DatabaseError, match="classifier's order"):
        sort_many([model], prepared.database, REVERSED, objects=10**6)
