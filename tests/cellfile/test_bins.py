"""The journal names the bin of every sort by the number that the sorter gets."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from beltsort.cell import Cell, Health, SortInto
from beltsort.cell.bins import REJECT, bin_of
from beltsort.cellfile.registry import BUILT_IN, Backend
from beltsort.models import paper
from beltsort.sim import SimulatedCell
from beltsort.sorting.entries import Intended
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.rules import Rules
from tests.cellfile.cell_files import NOTHING_SIMULATED, composed
from tests.cli.cells import PREPARE
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted

MODEL = paper()
BINS = "\nbins = {elongated = 4, livarno = 7, mushroom = 6, standard = 5}\nreject_bin = 9\nobjects = 10\n"
MAPPED = ("\nobjects = 10\n", BINS)
FILES = (PREPARE, 'model = "model.json"\nclassifier = "classifier.npz"')


class Press:
    """A sorter that notes what it is sent."""

    def __init__(self) -> None:
        self.numbers: list[int] = []

    def health(self) -> Health:
        return Health(ready=True, boot_id="press")

    def sort(self, label: int, command_id: str, *, timeout: float) -> None:
        self.numbers.append(label)


@pytest.fixture
def press(monkeypatch: pytest.MonkeyPatch) -> Press:
    press = Press()
    monkeypatch.setitem(BUILT_IN, "press", {"sorter": f"{__name__}:BACKEND"})
    monkeypatch.setattr(f"{__name__}.BACKEND", Backend(lambda _options, _cell: press))
    return press


BACKEND: Backend | None = None


def sorts(folder: Path, cell: Cell, rules: Rules) -> list[Intended]:
    """Sort three objects; return the intents of the sorts."""

    def seen() -> Iterator[list[int]]:
        for label in (3, 1, 1, 0):
            yield [label, (label + 2) % 4]

    path = folder / "journal.sqlite"
    with Journal(path) as journal:
        sort_objects(cell, scripted(seen()), LookOnce(), MODEL, journal, objects=3, rules=rules)
    intents = [entry.content for entry in read_journal(path) if isinstance(entry.content, Intended)]
    sorts = [intent for intent in intents if isinstance(intent.command.act, SortInto)]
    assert all(intent.bin is None and intent.number is None for intent in intents if intent not in sorts)
    return sorts


@pytest.mark.parametrize("mapped", [True, False])
@pytest.mark.parametrize("max_looks", [60, 1])
def test_the_journal_tells_the_number_that_the_sorter_gets(
    press: Press, tmp_path: Path, mapped: bool, max_looks: int
) -> None:
    at_press = ('[sorter]\nbackend = "simulated"', '[sorter]\nbackend = "press"')
    cell = composed(tmp_path, at_press, *NOTHING_SIMULATED, *([MAPPED] if mapped else []), live=True)
    intents = sorts(tmp_path, cell, Rules(max_looks=max_looks))
    assert len(intents) == len(press.numbers) == 3
    assert [intent.number for intent in intents] == press.numbers
    names, numbers = (*MODEL.classes, REJECT), (4, 7, 6, 5, 9) if mapped else range(4)
    labels = [intent.command.act.target for intent in intents]
    assert [(intent.bin, intent.number) for intent in intents] == [(names[n], numbers[n]) for n in labels]
    assert (REJECT in {intent.bin for intent in intents}) == (mapped and max_looks == 1)


def test_a_cell_that_numbers_no_bins_sends_labels(tmp_path: Path) -> None:
    cell = ScriptedCell(MODEL, reject_bin=17)
    intents = sorts(tmp_path, cell, Rules())
    assert [intent.number for intent in intents] == [target for name, target in cell.acts if name == "sort"]
    assert [intent.bin for intent in intents] == [MODEL.classes[intent.number or 0] for intent in intents]
    assert str(bin_of(cell, 17)) == 'bin "reject" (17)'


def test_a_simulated_sorter_has_its_bins_by_name(tmp_path: Path) -> None:
    devices: list[object] = []
    cell = composed(tmp_path, MAPPED, made=devices.append)
    intents = sorts(tmp_path, cell, Rules())
    (simulated,) = devices
    assert isinstance(simulated, SimulatedCell)
    labels = [intent.command.act.target for intent in intents]
    assert simulated.bins == list(enumerate(labels))
    assert [intent.number for intent in intents] == [(4, 7, 6, 5)[label] for label in labels]
    cell.sorter.sort(4, "rejected")
    assert simulated.bins[-1] == (3, 4), "the reject bin is behind the others, whatever its number is"


def test_a_simulated_sorter_may_have_fewer_bins_than_classes(tmp_path: Path) -> None:
    devices: list[object] = []
    two = ("\nobjects = 10\n", "\nobjects = 10\nbins = {glass = 7, metal = 3}\nreject_bin = 1\n")
    cell = composed(tmp_path, two, FILES, made=devices.append)
    assert cell.reject_bin == 2
    cell.sorter.sort(cell.reject_bin, "rejected")
    (simulated,) = devices
    assert isinstance(simulated, SimulatedCell)
    assert simulated.bins == [(0, 2)]


def test_a_real_sorter_sorts_what_simulated_devices_bring(press: Press, tmp_path: Path) -> None:
    at_press = ('[sorter]\nbackend = "simulated"', '[sorter]\nbackend = "press"')
    cell = composed(tmp_path, MAPPED, FILES, at_press, live=True)
    intents = sorts(tmp_path, cell, Rules())
    assert press.numbers == [intent.number for intent in intents]
    assert press.numbers == [(4, 7, 6, 5)[intent.command.act.target] for intent in intents]
