"""The benchmark of tables with modes: what it collects and what it says."""

import json
from argparse import Namespace
from pathlib import Path

import numpy as np
import pytest

from beltsort.sim.rounds import OBJECTS_OF_A_CLASS
from benchmarks.modes.__main__ import collect, main
from benchmarks.modes.measure import Matched

pytestmark = pytest.mark.slow
OBJECTS = 4 * OBJECTS_OF_A_CLASS  # of one passage


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("looks") / "looks"


@pytest.fixture(scope="module")
def matched(file: Path) -> Matched:
    return collect(Namespace(file=file, objects=OBJECTS // 2, seed=0, workers=1))


def test_labels_are_the_nearest_class(matched: Matched) -> None:
    seen = [position for scan in matched.scans for position in scan.seen]
    found = [position.match for position in seen if position.match is not None]
    assert len(found) > 0.9 * len(seen)
    assert all(match.label == match.distances.argmin() for match in found if match.distances is not None)
    looks = matched.looks(matched.rule(1, set(matched.poses)))
    assert (looks.labels == looks.true[looks.objects]).mean() > 0.5


def test_every_object_is_looked_at_twice_in_every_row(matched: Matched) -> None:
    looks = matched.looks(matched.rule(1, set(matched.poses)))
    assert len(looks) == OBJECTS
    np.testing.assert_array_equal(np.bincount(looks.true), OBJECTS_OF_A_CLASS)
    assert looks.known
    cells = np.zeros((OBJECTS, 2, 3), dtype=np.int64)
    np.add.at(cells, (looks.objects, looks.positions, looks.viewpoints), 1)
    np.testing.assert_array_equal(cells, 2)


def test_half_of_the_labels_are_confident(matched: Matched) -> None:
    everything = set(matched.poses)
    labels, classes = (matched.looks(matched.rule(levels, everything)).labels for levels in (2, 1))
    found = labels != -1
    assert (labels[found] % 2).mean() == pytest.approx(0.5, abs=0.01)
    np.testing.assert_array_equal(labels[found] // 2, classes[found])


def test_the_benchmark_as_json(matched: Matched, file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert len(matched.scans) > 0
    given = [str(file), "--objects", str(OBJECTS // 2), "--modes", "2", "--json"]
    assert main(given) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    # Four candidates for class labels, three for two levels, where sticky labels are too many kinds.
    assert len({(row["labels"], row["candidate"]) for row in rows}) == len(rows) == 7
    assert all(row["looks"] == [4, 8, 12] and min(row["log_loss"]) > 0.0 for row in rows)
