"""The state of a run is of bounded size, and its counts are those of the whole run."""

import tracemalloc
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain, repeat
from pathlib import Path

import pytest

from beltsort import Decide, Move
from beltsort.cell.commands import AdvanceTo, SortInto
from beltsort.models import paper
from beltsort.sorting.command import Command
from beltsort.sorting.entries import (
    AnyContent,
    CommandDone,
    Decided,
    Intended,
    ObjectsPassed,
    Skipped,
    Snapshot,
    Started,
)
from beltsort.sorting.journal import BATCH, Entry, Journal, entries_of_journal, iterate_after, read_journal
from beltsort.sorting.journal_files import JOURNAL, full_files
from beltsort.sorting.journal_queries import entries_before, entries_since
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import Counts
from beltsort.sorting.run_state import LATEST
from beltsort.sorting.status import status_of
from tests.sorting.scripted_cell import EMPTY, Glimpse, LookOnce, ScriptedCell, scripted

MODEL = paper()
START = Started(run="a", objects=None, model=MODEL.to_json())


def life_of(index: int) -> Iterator[AnyContent]:
    """Yield what a run writes about an object: each tenth cup is empty, each seventh decision forced."""
    if index % 10 == 3:
        yield Skipped([0, 1], decided=False)
    else:
        forced = "max_looks" if index % 7 == 0 else None
        yield Decided(index % 4, index % 4, 0.9, 2, forced, true_class=index % 3)
        yield from done(Command(f"a-sort-{index}", SortInto(index % 4), "b"))
    yield from done(Command(f"a-advance-{index}", AdvanceTo(index + 1), "b"))


def done(command: Command) -> Iterator[AnyContent]:
    yield Intended(command)
    yield CommandDone(command.id)


def entries(objects: int) -> Iterator[Entry]:
    contents = chain([START], *(life_of(index) for index in range(objects)))
    return (Entry(number, "", None, content) for number, content in enumerate(contents, start=1))


def test_counts_are_those_of_all_objects_and_the_latest_are_kept() -> None:
    bounded, whole = (Progress.after(entries(1500), keep) for keep in (LATEST, None))
    assert bounded.counts == whole.counts
    assert (len(whole.decisions), len(whole.skipped)) == (1350, 150)
    assert bounded.decisions == whole.decisions[-LATEST:]
    counts = whole.counts
    assert (counts.sorted, counts.skipped) == (1350, 150)
    assert counts.forced == sum(decision.forced is not None for decision in whole.decisions)
    for label in range(4):
        assert counts.bins[label] == sum(decision.label == label for decision in whole.decisions)
        for true in range(3):
            expected = sum((d.label, d.true_class) == (label, true) for d in whole.decisions)
            assert counts.confusion is not None
            assert counts.confusion[label][true] == expected


def test_the_state_does_not_grow() -> None:
    """Without a bound, a thousand decisions take a hundred times as much."""
    progress = Progress.after(entries(1), keep=50)
    sizes = []
    tracemalloc.start()
    for index in range(1, 3001):
        for content in life_of(index):
            progress.apply(Entry(0, "", index, content))
        if index % 1000 == 0:
            sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert sizes[-1] - sizes[-2] < 5_000
    assert (len(progress.decisions), len(progress.skipped), progress.counts.sorted) == (50, 50, 2701)


def test_a_decision_that_never_reached_its_bin_is_not_counted() -> None:
    """Also if the state has gone through a snapshot in between."""
    progress = Progress.after(entries(3))
    before = progress.counts
    progress.apply(Entry(0, "", 3, Decided(1, 1, 0.9, 2, None, true_class=1)))
    assert progress.counts.sorted == before.sorted + 1
    again = Progress.after([Entry(1, "", 3, progress.snapshot())])
    for each in (progress, again):
        each.apply(Entry(0, "", 3, ObjectsPassed(5)))
        assert each.counts == replace(before, passed=2)
        assert each.passed == [3, 4]


def test_a_resumed_run_knows_whether_the_object_at_the_belt_end_was_sorted() -> None:
    progress = Progress.after(entries(3))
    for content in chain([Decided(1, 1, 0.9, 2, None)], done(Command("a-sort-3", SortInto(1), "b"))):
        progress.apply(Entry(0, "", 3, content))
    assert progress.taken
    assert Progress.after([Entry(1, "", 3, progress.snapshot())]).taken


@pytest.mark.parametrize("with_counts", [True, False])
def test_counts_of_a_journal_of_several_files(tmp_path: Path, with_counts: bool) -> None:
    """Snapshots of older versions have no counts, and the decisions are read from all files."""
    path = tmp_path / JOURNAL
    seen: list[Sequence[Glimpse] | str] = [[1, 2], [EMPTY, 2], [EMPTY, 2], *[[2, 3]] * 50]
    with Journal(path, largest=12_000, keep=99) as journal:
        report = sort_objects(*(ScriptedCell(MODEL), scripted(seen), LookOnce(), MODEL, journal), objects=12)
        if not with_counts:
            snapshot = progress_in(path).snapshot()
            journal.rotate(replace(snapshot, counts=None, decision=None))
    assert len(full_files(path)) >= 3
    assert progress_in(path).counts == report.counts == Counts(report.counts.bins, skipped=1)
    assert report.counts.sorted == 11
    status = status_of(tmp_path)
    assert (sum(status.bins.values()), status.skipped, status.condition) == (11, 1, "finished")


def test_counts_outlast_the_files_that_are_dropped(tmp_path: Path) -> None:
    path = tmp_path / JOURNAL
    with Journal(path, largest=12_000, keep=1) as journal:
        sort_objects(*(ScriptedCell(MODEL), scripted(repeat([2, 3])), LookOnce(), MODEL, journal), objects=12)
    kept = [entry for entry in read_journal(path) if isinstance(entry.content, Decided)]
    assert len(kept) < 12
    assert sum(status_of(tmp_path).bins.values()) == 12


def test_entries_are_read_in_batches_from_all_files(tmp_path: Path) -> None:
    path = tmp_path / JOURNAL
    contents = list(entries(BATCH // 4))
    with Journal(path) as journal:
        for position, entry in enumerate(contents):
            if position in (500, 700):
                journal.rotate(Progress.after(contents[:position]).snapshot())
            journal.append(entry.content)
        following = iterate_after(path, 0)
        read = [next(following) for _ in range(600)]
        journal.rotate(Progress.after(contents).snapshot())  # while somebody reads
        read += following
    numbers = [entry.number for entry in read]
    assert len(numbers) > BATCH
    assert numbers == list(range(1, len(contents) + 4))
    assert [entry.number for entry in entries_of_journal(path)] == numbers
    decided = [entry.number for entry in read if isinstance(entry.content, Decided)]
    assert [entry.number for entry in entries_before(path, 10**6, [Decided.kind])] == decided[::-1]
    last = max(entry.number for entry in read[:-1] if isinstance(entry.content, Snapshot))
    since = [entry.number for entry in entries_since(path, "skip", ["skip", "decision"])]
    skipped = max(entry.number for entry in read if isinstance(entry.content, Skipped))
    assert since == [number for number in numbers if number >= skipped and number in {*decided, skipped}]
    assert last < skipped


def test_a_simulated_cell_says_what_was_right(tmp_path: Path) -> None:
    """Also if the number of objects is not limited, when the classes are not kept."""

    class Simulated(ScriptedCell):
        def true_class(self, index: int) -> int | None:
            return index % 2

    class DecideTwo:
        def act(self, *_: object) -> Move | Decide:
            return Decide(1)

    with Journal(tmp_path / JOURNAL) as journal:
        report = sort_objects(
            *(Simulated(MODEL), scripted(repeat([1, 1])), DecideTwo(), MODEL, journal), objects=5
        )
    assert report.counts.confusion == ((0, 0, 0, 0), (3, 2, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0))
    assert progress_in(tmp_path / JOURNAL).counts == report.counts
