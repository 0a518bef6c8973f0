"""A run that is killed anywhere goes on as if it had not been."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from beltsort.errors import JournalError
from beltsort.sorting.entries import Decided
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from tests.sorting.killed_run import MODEL, OBJECTS, FileWorld, perceive, planner, run
from tests.sorting.plant import plant

pytestmark = pytest.mark.process

KILLED = -9


def killed(folder: Path, point: str, *words: str, resume: bool = False) -> None:
    """Run a process to where it kills itself."""
    arguments = [sys.executable, "-m", "tests.sorting.killed_run", str(folder), point, *words]
    done = subprocess.run([*arguments, *(["resume"] if resume else [])], check=False)
    assert done.returncode == KILLED


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> tuple[SortingReport, Path]:
    folder = tmp_path_factory.mktemp("uninterrupted")
    return run(folder, "never", resume=False), folder


def points(folder: Path, count: int, seed: int) -> list[str]:
    """Moments to be killed at: the first half after an entry, the others after an act of the world."""
    rng = np.random.default_rng(seed)
    entries = len(read_journal(folder / "journal.sqlite"))
    world = FileWorld(folder / "world.sqlite")
    acts = sum(len(world.acts(name)) for name in ("move", "sort", "advance"))
    after_entries = rng.choice(np.arange(1, entries), size=count - count // 2, replace=False)
    after_acts = rng.choice(np.arange(1, acts + 1), size=count // 2, replace=count // 2 > acts)
    return [*(f"entry:{n}" for n in after_entries), *(f"act:{n}" for n in after_acts)]


def check_as_if_uninterrupted(folder: Path, report: SortingReport, expected: SortingReport) -> None:
    assert report == expected
    world = FileWorld(folder / "world.sqlite")
    assert world.acts("sort") == [decision.label for decision in expected.decisions], "each once, in order"
    assert world.acts("advance") == list(range(1, OBJECTS + 1))
    assert progress_in(folder / "journal.sqlite").done


def test_killed_once_anywhere(tmp_path: Path, uninterrupted: tuple[SortingReport, Path]) -> None:
    expected, folder = uninterrupted
    for number, point in enumerate(points(folder, 10, seed=1)):
        here = tmp_path / str(number)
        here.mkdir()
        killed(here, point)
        check_as_if_uninterrupted(here, run(here, "never", resume=True), expected)


def test_killed_again_and_again(tmp_path: Path, uninterrupted: tuple[SortingReport, Path]) -> None:
    killed(tmp_path, "entry:3")
    for point in ("entry:9", "act:4", "entry:31", "entry:32", "act:11"):
        killed(tmp_path, point, resume=True)
    check_as_if_uninterrupted(tmp_path, run(tmp_path, "never", resume=True), uninterrupted[0])


def test_a_finished_run_has_nothing_left_to_do(tmp_path: Path) -> None:
    report = run(tmp_path, "never", resume=False)
    acts = len(read_journal(tmp_path / "journal.sqlite"))
    assert run(tmp_path, "never", resume=True) == report
    assert len(read_journal(tmp_path / "journal.sqlite")) == acts + 4, "resume, two states and an end"
    with pytest.raises(JournalError, match=r"\bjournal\.sqlite exists\b"):
        Journal(tmp_path / "journal.sqlite")


def test_a_run_in_small_files_is_resumed_from_the_last_of_them(
    tmp_path: Path, uninterrupted: tuple[SortingReport, Path]
) -> None:
    world = FileWorld(tmp_path / "world.sqlite")
    path = tmp_path / "journal.sqlite"
    with Journal(path, largest=20_000, keep=1) as journal:
        report = sort_objects(world, perceive, planner(), MODEL, journal, objects=OBJECTS, belt_ends=True)
    assert report == uninterrupted[0]
    entries = read_journal(path)
    assert entries[0].kind == "snapshot"
    progress = progress_in(path)
    assert (progress.steps, progress.index, progress.done) == (report.steps, OBJECTS, True)
    assert progress.belief.remaining == 0
    assert 0 < len(progress.decisions) < OBJECTS


def test_a_killed_run_keeps_bins_that_are_not_classes(tmp_path: Path) -> None:
    model, whole = plant(), tmp_path / "whole"
    whole.mkdir()
    expected = run(whole, "never", resume=False, model=model)
    entries = read_journal(whole / "journal.sqlite")
    decided = [entry.number for entry in entries if isinstance(entry.content, Decided)]
    acts = FileWorld(whole / "world.sqlite").database.execute("SELECT number FROM acts WHERE name = 'sort'")
    sorts = [number for (number,) in acts]
    for point in (f"entry:{decided[2]}", f"entry:{decided[4] + 1}", f"act:{sorts[3]}"):
        here = tmp_path / point.replace(":", "-")
        here.mkdir()
        killed(here, point, "plant")
        check_as_if_uninterrupted(here, run(here, "never", resume=True, model=model), expected)
