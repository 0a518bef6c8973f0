"""Runs on a simulated belt that never stops, and what must hold of each."""

from collections import Counter
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np

import beltsort
from beltsort import MovingBelt, MovingPlanner
from beltsort.planning.policy import MovingPolicy
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.moving.entries import Diverting, Fate, ObjectLeft
from beltsort.sorting.moving.loop import resume_moving, sort_moving
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.rules import Rules
from tests.sorting.moving.cells import MovingPlant, Perception

MODEL = beltsort.SortingModel.load("tests/fixtures/paper.json")
RULES = Rules(retry_delays=(0.01, 0.02))


def moving_belt(model: beltsort.SortingModel = MODEL) -> MovingBelt:
    """The paper's model on a belt that takes 3 s for a place; a move takes 2 s."""
    moves = [[0 if a == b else 4 for b in range(3)] for a in range(3)]
    return MovingBelt(model, ticks_per_place=6, reach=2, move_ticks=moves, scan_ticks=1, seconds_per_tick=0.5)


BELT = moving_belt()


def plant(objects: int = 12, seed: int = 3) -> MovingPlant:
    """A belt of bulbs, a tenth of the cups empty."""
    rng = np.random.default_rng(seed)
    labels = [int(label) if rng.random() > 0.1 else None for label in rng.integers(4, size=objects)]
    return MovingPlant(MODEL, labels, speed=0.06, seed=seed)


@lru_cache
def planner(trials: int = 2) -> MovingPlanner:
    """The recommended planner."""
    return MovingPlanner(BELT, trials=trials)


def sort(
    folder: Path,
    cell: MovingPlant,
    policy: MovingPolicy | None = None,
    *,
    objects: int | None = 12,
    check: Callable[[], None] = lambda: None,
    requests: Path | None = None,
) -> MovingReport:
    """Sort the objects of a plant."""
    with Journal(folder / "journal.sqlite") as journal:
        return sort_moving(
            *(cell, Perception(cell), policy or planner(), BELT, journal),
            objects=objects,
            rules=RULES,
            check=check,
            requests=requests,
        )


def resume(
    folder: Path,
    cell: MovingPlant,
    policy: MovingPolicy | None = None,
    *,
    check: Callable[[], None] = lambda: None,
) -> MovingReport:
    """Resume the run in a folder."""
    with Journal(folder / "journal.sqlite", resume=True) as journal:
        return resume_moving(cell, Perception(cell), policy or planner(), journal, rules=RULES, check=check)


def entries(folder: Path) -> list[Entry]:
    """The entries of a run."""
    return read_journal(folder / "journal.sqlite")


def check_accounts(folder: Path, cell: MovingPlant, objects: int = 12) -> dict[int, Fate]:
    """Check that every object is told once, and is where it is said to be; return how each has left."""
    told = [entry.content for entry in entries(folder) if isinstance(entry.content, ObjectLeft)]
    assert [count for count in Counter(left.number for left in told).values() if count > 1] == []
    fates = {left.number: left.fate for left in told}
    assert sorted(fates) == list(range(objects))
    sent = [entry.content for entry in entries(folder) if isinstance(entry.content, Diverting)]
    assert len({each.number for each in sent}) == len(sent), "an object has two diversions"
    if cell.belt.boots == 1:
        anchor = next(entry.content for entry in entries(folder) if entry.kind == "anchor")
        first = round(anchor.origin / cell.layout.spacing)  # type: ignore[union-attr] # of that kind
        in_bins = {cup - first: bin for cup, bin in cell.belt.in_bins.items()}
        said = {each.number: each.bin for each in sent if fates[each.number] is Fate.IN_BIN}
        assert said == in_bins
    return fates
