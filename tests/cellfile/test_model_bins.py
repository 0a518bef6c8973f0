"""Bins of a cell file for a model whose bins are not its classes."""

from collections import Counter
from pathlib import Path

import pytest

from beltsort import Belief, Decide, Move, SortingModel
from beltsort.cell import Scan, SortInto
from beltsort.cellfile.bins import with_bins_of
from beltsort.cellfile.composed import compose
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.registry import BUILT_IN, Backend
from beltsort.cellfile.run import open_run
from beltsort.models import paper
from beltsort.planning.decisions import best_bin
from beltsort.sorting.entries import Decided, Intended
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.rules import Rules
from beltsort.testing.controller import Machine
from tests.cellfile.cell_files import EXAMPLE, NOTHING_SIMULATED, described
from tests.cli.cells import PREPARE
from tests.contract.test_device import SortingStation
from tests.sorting.plant import BINS, CLASSES, LABELS, plant
from tests.sorting.scripted_cell import Glimpsed

VIEWPOINTS = ("p1", "p2", "p3")
MODEL = plant(VIEWPOINTS)
FOUR = '{mercury = 4, "by hand" = 7, glass = 1, electronics = 2}'
EXAMPLE_CLASSES = next(line for line in EXAMPLE.read_text().splitlines() if line.startswith("classes"))
FILES = (PREPARE, 'model = "model.json"\nclassifier = "classifier.npz"')


def cell_of(folder: Path, bins: str | None, *changes: tuple[str, str]) -> CellDescription:
    """Describe a cell of the plant's classes."""
    table = "" if bins is None else f"\nbins = {bins}"
    classes = (EXAMPLE_CLASSES, f"classes = {list(CLASSES)}{table}")
    return described(folder, FILES, classes, *NOTHING_SIMULATED, *changes)


def test_the_bins_are_ordered_as_the_models(tmp_path: Path) -> None:
    description = cell_of(tmp_path, FOUR, ("\nobjects = 10\n", "\nobjects = 10\nreject_bin = 9\n"))
    assert description.bin_numbers == (4, 7, 1, 2, 9)
    fitted = with_bins_of(MODEL, description)
    assert (fitted.bin_names, fitted.bin_numbers) == (BINS, (1, 2, 4, 7, 9))
    assert fitted.path("model.json") == description.path("model.json")
    cell = compose(fitted, live=False, say=print)
    assert (cell.bin_names, cell.reject_bin, cell.classes) == (BINS, 4, CLASSES)


def test_bins_of_classes_are_as_ever(tmp_path: Path) -> None:
    model, bins = paper(), "bins = {standard = 5, elongated = 4, livarno = 4, mushroom = 6}"
    description = described(tmp_path, FILES, ("\nobjects = 10\n", f"\n{bins}\n"))
    assert with_bins_of(model, description).bin_numbers == description.bin_numbers == (4, 4, 6, 5)
    without = described(tmp_path, FILES)
    assert with_bins_of(model, without) is without


@pytest.mark.parametrize("bins", [None, "{nut = 2, bolt = 3}", "{nut = 2, bolt = 3, none = 4}"])
def test_a_last_bin_for_empty_cups_may_be_missing(tmp_path: Path, bins: str | None) -> None:
    tables = [[[[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8]]]]
    model = SortingModel(["nut", "bolt", "none"], ["p1"], tables, empty="none")
    table = "" if bins is None else f"\nbins = {bins}"
    description = described(
        tmp_path, FILES, (EXAMPLE_CLASSES, f'classes = ["nut", "bolt"]{table}'), *NOTHING_SIMULATED
    )
    assert len(with_bins_of(model, description).bin_numbers) == (3 if "none" in table else 2)


OF_CLASSES = "{" + ", ".join(f'"{name}" = {number}' for number, name in enumerate(CLASSES)) + "}"

WRONG = [
    (None, r"^bins: is missing\b.*\['halogen', .*expected \['glass', .*\bnumber\b"),
    (OF_CLASSES, r"^bins: .*\bclasses \['halogen', .*\bbins of its own\b.*expected \['glass', .*\bnumber\b"),
    ("{glass = 1, mercury = 2, electronics = 3}", r"^bins: .*\bno \['by hand'\]; expected \['glass', "),
    (
        FOUR.replace("mercury", "mecury"),
        r"^bins: .*no \['mercury'\] and \['mecury'\], .*; expected \['glass', ",
    ),
    (
        FOUR[:-1] + ", paper = 3}",
        r"^bins: .*: \['paper'\], which the model does not have; expected \['glass', ",
    ),
]


@pytest.mark.parametrize(("bins", "said"), WRONG)
def test_bins_that_do_not_fit_are_told(tmp_path: Path, bins: str | None, said: str) -> None:
    with pytest.raises(CellFileError, match=said):
        with_bins_of(MODEL, cell_of(tmp_path, bins))


def test_a_run_tells_before_it_makes_a_device(tmp_path: Path) -> None:
    description = cell_of(tmp_path, None, ('"dry-run"', '"nowhere"'))
    MODEL.save(tmp_path / "model.json")
    with pytest.raises(CellFileError, match=r"^bins: is missing\b"):
        open_run(description, tmp_path, live=False, say=print)


def test_the_reject_bin_is_none_of_the_models(tmp_path: Path) -> None:
    with pytest.raises(CellFileError, match=r'^reject_bin: is 7\b.*"by hand"'):
        cell_of(tmp_path, FOUR, ("\nobjects = 10\n", "\nobjects = 10\nreject_bin = 7\n"))


class Seen:
    """A perception that sees the classes in turn; every fourth time it is unsure."""

    labels = LABELS

    def __init__(self) -> None:
        self.scans = -1

    def __call__(self, _scan: Scan) -> list[Glimpsed]:
        self.scans += 1
        sure = int(self.scans % 4 > 0)
        return [Glimpsed(2 * ((self.scans + place) % 6) + sure, empty=False) for place in range(2)]


class LookOnce:
    """Looks at each object once, then decides the bin that earns most."""

    looked = False

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        self.looked = not self.looked
        return Move(1) if self.looked else Decide(best_bin(belief))


@pytest.fixture
def station(monkeypatch: pytest.MonkeyPatch) -> SortingStation:
    station = SortingStation(Machine(bins=10, sort_seconds=0.0, advance_seconds=0.0))
    device = station.device()
    monkeypatch.setitem(BUILT_IN, "station", dict.fromkeys(("belt", "sorter"), f"{__name__}:STATION"))
    monkeypatch.setattr(f"{__name__}.STATION", Backend(lambda _options, _cell: device, shared=True))
    return station


STATION: Backend | None = None


@pytest.mark.parametrize("max_looks", [60, 1])
def test_the_controller_gets_the_sorters_numbers(
    station: SortingStation, tmp_path: Path, max_looks: int
) -> None:
    at_station = [
        (f'[{role}]\nbackend = "dry-run"', f'[{role}]\nbackend = "station"') for role in ("belt", "sorter")
    ]
    rejecting = ("\nobjects = 10\n", "\nobjects = 10\nreject_bin = 9\n")
    description = with_bins_of(MODEL, cell_of(tmp_path, FOUR, rejecting, *at_station))
    cell = compose(description, live=True, say=print)
    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        report = sort_objects(
            cell, Seen(), LookOnce(), MODEL, journal, objects=12, rules=Rules(max_looks=max_looks)
        )
    contents = [entry.content for entry in read_journal(path)]
    sorts = [c for c in contents if isinstance(c, Intended) and isinstance(c.command.act, SortInto)]
    numbers = {"glass": 1, "electronics": 2, "mercury": 4, "by hand": 7, "reject": 9}
    assert [intent.number for intent in sorts] == [numbers[str(intent.bin)] for intent in sorts]
    sent = Counter(intent.number for intent in sorts)
    assert station.bins == tuple(sent[number] for number in range(10))
    assert [intent.bin for intent in sorts] == [c.name for c in contents if isinstance(c, Decided)]
    decided = ["reject" if d.label is None else BINS[d.label] for d in report.decisions]
    assert [intent.bin for intent in sorts] == decided
    assert (9 in sent) == (max_looks == 1)
    assert len(sent) >= (2 if max_looks == 1 else 3)
