"""Sorting into bins that are not the classes, by labels that are not the classes either."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort import Belief, Decide, Move
from beltsort.cell import Scan
from beltsort.errors import CellError
from beltsort.models import paper
from beltsort.planning.decisions import best_bin, probability_right, right_bins
from beltsort.planning.policy import Policy
from beltsort.sorting.audit import steps_of
from beltsort.sorting.belief_figure import belief_over_time
from beltsort.sorting.entries import Chosen, Decided, Intended, Scanned
from beltsort.sorting.entry_format import content_of, plain
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.progress import Progress
from beltsort.sorting.report import SortingReport, confusion
from beltsort.sorting.rules import Drift, Rules
from tests.sorting.plant import BIN_OF, BINS, LABELS, Levels, PlantCell, plant
from tests.sorting.scripted_cell import EMPTY, Glimpsed, ScriptedCell, scripted

MODEL = plant()
OBJECTS = 6


def run(
    folder: Path,
    cell: PlantCell,
    policy: Policy | None = None,
    rules: Rules | None = None,
    interrupt_at: int | None = None,
    *,
    resume: bool = False,
    largest: int = 10**9,
) -> SortingReport:
    def listener(entry: Entry) -> None:
        if entry.number == interrupt_at:
            raise KeyboardInterrupt

    policy = policy or beltsort.Despot(MODEL, trials=20, scenarios=100)
    drift = Drift(false_alarm=0.001)
    with Journal(folder / "journal.sqlite", listener, resume=resume, largest=largest) as journal:
        if resume:
            return resume_sorting(cell, Levels(), policy, journal, rules=rules, drift=drift)
        return sort_objects(cell, Levels(), policy, MODEL, journal, objects=OBJECTS, rules=rules, drift=drift)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("plant")


@pytest.fixture(scope="module")
def whole(folder: Path) -> tuple[SortingReport, PlantCell]:
    cell = PlantCell(MODEL)
    return run(folder, cell), cell


def sorts(cell: ScriptedCell) -> list[int]:
    return [target for name, target in cell.acts if name == "sort"]


def test_decisions_are_bins(whole: tuple[SortingReport, PlantCell], folder: Path) -> None:
    report, cell = whole
    assert sorts(cell) == [decision.label for decision in report.decisions]
    assert sum(report.counts.by_bin(BINS).values()) == OBJECTS
    entries = read_journal(folder / "journal.sqlite")
    into = [e.content.bin for e in entries if isinstance(e.content, Intended) and e.content.bin is not None]
    assert into == [e.content.name for e in entries if isinstance(e.content, Decided)]
    assert into == [BINS[bin] for bin in sorts(cell)] == [name for _, name in belief_over_time(entries)[1]]
    formatter = EntryFormatter()
    text = "\n".join(line for entry in entries if (line := formatter.format(entry)))
    assert all(f"decide {name}" in text for name in into)
    assert any(f"look from side: {label} | " in text for label in LABELS)


def test_the_belief_follows_the_models_own_labels(
    whole: tuple[SortingReport, PlantCell], folder: Path
) -> None:
    belief = Belief(MODEL)
    first = next(e.content for e in read_journal(folder / "journal.sqlite") if isinstance(e.content, Scanned))
    belief.observe(first.viewpoint, first.labels)
    assert first.kinds == belief.kinds.tolist()
    assert first.belief == belief.probabilities.tolist()
    assert content_of("scan", plain(first)) == first


def test_the_confidence_of_a_decision_is_that_its_bin_is_right(
    whole: tuple[SortingReport, PlantCell], folder: Path
) -> None:
    entries = read_journal(folder / "journal.sqlite")
    decided = [e.content for e in entries if isinstance(e.content, Decided)]
    steps = [step for step in steps_of(entries) if isinstance(step.action, Decide)]
    assert [step.action for step in steps] == [Decide(content.bin) for content in decided]
    for step, content in zip(steps, decided, strict=True):
        rows = step.belief.probabilities[0]
        right = [rows[c] for c in range(6) if BIN_OF[c] == content.label]
        assert content.belief == pytest.approx(sum(right))


def test_objects_are_counted_by_bin_and_class(whole: tuple[SortingReport, PlantCell]) -> None:
    report, cell = whole
    decisions = [(decision.object, decision.label) for decision in report.decisions]
    counts = confusion(decisions, cell.true_class, MODEL)
    assert counts.shape == (4, 6)
    assert counts.sum() == OBJECTS
    assert [*counts.sum(axis=1)] == [sorts(cell).count(bin) for bin in range(4)]
    right = sum(BIN_OF[cell.true_class(number)] == bin for number, bin in decisions)
    assert counts[right_bins(MODEL)].sum() == right
    assert confusion([(0, None)], cell.true_class, MODEL).sum() == 0


def test_a_run_interrupted_anywhere_keeps_its_bins(
    tmp_path: Path, whole: tuple[SortingReport, PlantCell], folder: Path
) -> None:
    expected, uninterrupted = whole
    last = len(read_journal(folder / "journal.sqlite"))
    for number in range(3, last, 11):
        here = tmp_path / str(number)
        here.mkdir()
        cell = PlantCell(MODEL)
        with pytest.raises(KeyboardInterrupt):
            run(here, cell, interrupt_at=number)
        assert run(here, cell, resume=True) == expected
        assert sorts(cell) == sorts(uninterrupted)


def test_a_snapshot_keeps_kinds_and_bin(whole: tuple[SortingReport, PlantCell], folder: Path) -> None:
    entries = read_journal(folder / "journal.sqlite")
    progress = Progress.at_start(MODEL)
    for entry in entries:
        progress.apply(entry)
        snapshot = progress.snapshot()
        assert content_of("snapshot", plain(snapshot)) == snapshot
        again = Progress.after([Entry(1, "", 0, snapshot)])
        np.testing.assert_array_equal(again.belief.kinds, progress.belief.kinds)
        assert again.bin == progress.bin
    assert any(isinstance(e.content, Decided) for e in entries)


class LookOn:
    """Never decides."""

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        return Move(1)


@pytest.mark.parametrize("reject_bin", [None, 4])
def test_looking_ends_with_the_bin_that_earns_most(tmp_path: Path, reject_bin: int | None) -> None:
    cell = PlantCell(MODEL, reject_bin=reject_bin)
    report = run(tmp_path, cell, LookOn(), Rules(max_looks=1))
    entries = read_journal(tmp_path / "journal.sqlite")
    for step, decision in zip((s for s in steps_of(entries) if s.reason), report.decisions, strict=True):
        expected = MODEL.reward @ step.belief.probabilities[0]
        best = int(np.argmax(expected))
        assert step.action == Decide(best)
        assert decision.label == (None if reject_bin else best)
        assert decision.belief == pytest.approx(probability_right(step.belief, best))
    likely = [step.belief.most_likely(0)[0] for step in steps_of(entries) if step.reason]
    assert [BIN_OF[c] for c in likely] != sorts(cell), "the bin that earns most is another one's at times"
    assert report.counts.by_bin(BINS).get("rejected", 0) == (OBJECTS if reject_bin else 0)


def test_equal_bins_are_decided_in_order() -> None:
    classes = [f"c{i}" for i in range(7)]
    model = beltsort.SortingModel(classes, ["v"], [[np.eye(7)]], r_min=0.1)
    assert best_bin(Belief(model)) == 0
    for probabilities in np.random.default_rng(0).dirichlet(np.ones(7), 50):
        belief = Belief(model, [probabilities])
        assert best_bin(belief) == belief.most_likely(0)[0]
        assert probability_right(belief, 3) == belief.probabilities[0, 3]


def test_an_illegal_bin_is_refused(tmp_path: Path) -> None:
    class TooFar:
        def act(self, belief: Belief, viewpoint: int) -> Decide:
            return Decide(4)

    with pytest.raises(beltsort.PolicyError, match=r"label=4.*label=3"):
        run(tmp_path, PlantCell(MODEL), TooFar())


class Named:
    """A perception with other labels."""

    def __init__(self, labels: Sequence[str]) -> None:
        self.labels = labels

    def __call__(self, scan: Scan) -> list[Glimpsed]:
        return []


@pytest.mark.parametrize(
    ("labels", "said"),
    [
        (LABELS[1:], r"cannot give \['halogen, unsure'\].*\brule\b"),
        ((*LABELS, "not recognised"), r"gives \['not recognised'\].*\brule\b"),
        (None, r"perception's are \['halogen', 'spot', .*cannot give \['halogen, unsure', "),
    ],
)
def test_labels_that_do_not_fit_are_told(tmp_path: Path, labels: Sequence[str] | None, said: str) -> None:
    perceive = scripted([]) if labels is None else Named(labels)
    with (
        Journal(tmp_path / "j") as journal,
        pytest.raises(CellError, match=rf"labels are \['halogen, unsure', .*{said}"),
    ):
        sort_objects(PlantCell(MODEL), perceive, LookOn(), MODEL, journal, objects=1)


def test_a_label_out_of_range_is_told(tmp_path: Path) -> None:
    model = paper()
    with (
        Journal(tmp_path / "j") as journal,
        pytest.raises(beltsort.ArgumentError, match=r"label 4\b.*\b0 to 3 \(elongated, "),
    ):
        sort_objects(ScriptedCell(model), scripted([[4, 0]]), LookOn(), model, journal, objects=1)


def test_a_cell_with_other_bins_is_refused(tmp_path: Path) -> None:
    with (
        Journal(tmp_path / "j") as journal,
        pytest.raises(CellError, match=r"cell's bins are \['halogen', .*model's \['glass', .*\bin order\b"),
    ):
        sort_objects(ScriptedCell(MODEL), Levels(), LookOn(), MODEL, journal, objects=1)


def test_the_bin_named_like_the_empty_class_passes_over_the_place(tmp_path: Path) -> None:
    """Two classes share a bin; an empty cup has a label and a bin of its name."""
    table = np.full((3, 3), 0.05) + 0.85 * np.eye(3)
    model = beltsort.SortingModel(
        ["nut", "bolt", "none"],
        ["v", "w"],
        np.tile(table, (2, 2, 1, 1)),
        bins=["metal", "none"],
        reward=[[10, 10, -5], [-5, -5, 10]],
        empty="none",
    )

    class Metal(ScriptedCell):
        bin_names = ("metal",)

    class DecideAfterOne:
        looked = False

        def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
            self.looked = not self.looked
            return Move(1) if self.looked else Decide(best_bin(belief))

    cell, path = Metal(model), tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        scans = scripted([[1, EMPTY], [EMPTY, 0], [0, EMPTY]])
        report = sort_objects(cell, scans, DecideAfterOne(), model, journal, objects=3)
    assert report.skipped == (1,)
    assert sorts(cell) == [0, 0]
    assert [e.content.labels for e in read_journal(path) if isinstance(e.content, Scanned)] == [
        [1, 2],
        [2, 0],
        [0, 2],
    ]
    assert any(isinstance(e.content, Chosen) for e in read_journal(path))
