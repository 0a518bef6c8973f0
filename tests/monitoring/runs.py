"""A run of a scripted cell in which much happens, for whoever listens to it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.models import paper
from beltsort.sorting.journal import Journal, Listeners
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.loop import resume_sorting
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Rules
from beltsort.sorting.runs import sort_into
from tests.sorting.scripted_cell import EMPTY, UNUSABLE, Glimpse, LookOnce, ScriptedCell, scripted

RULES = Rules(retry_delays=(0.0,), empty_looks=1)
SEEN: list[Sequence[Glimpse] | str] = [[1, 2], UNUSABLE, [EMPTY, 2], *[[2, 3]] * 50]
"""Object 1 is an empty cup, of which the first scan is unusable."""


@dataclass
class Stubborn(ScriptedCell):
    """Refuses a few sorts from its second on."""

    refused: int = 1
    sorts: int = 0

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        self.sorts += 1
        if 2 <= self.sorts < 2 + self.refused:
            raise CommandError("the bin is full; empty it", Outcome.NOT_DONE)
        super().sort(label, command_id, timeout=timeout)


def run_of(folder: Path, listeners: Listeners, *, refused: int = 1) -> SortingReport:
    """Sort four objects; the second sort is refused a few times."""
    model = paper()
    cell = Stubborn(model, refused=refused)
    sorted_with = (folder, cell, scripted(SEEN), LookOnce(), model)
    return sort_into(*sorted_with, objects=4, rules=RULES, listener=listeners)


def resumed(folder: Path, listeners: Listeners, *, first: int) -> SortingReport:
    """Resume a run with object `first` at the belt end."""
    cell = ScriptedCell(paper(), first=first)
    with Journal(folder / JOURNAL, listeners, resume=True) as journal:
        return resume_sorting(cell, scripted(SEEN[3:]), LookOnce(), journal, rules=RULES)
