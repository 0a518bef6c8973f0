"""A run of ten objects that kills itself: `python -m tests.sorting.killed_run FOLDER POINT [resume] [plant]`.

POINT is `entry:N` (when entry N has been written), `act:N` (when the world has carried out its N-th command,
before anyone knows) or `never`. With `plant`, the model's labels and bins are not its classes.
"""

import os
import signal
import sqlite3
import sys
from pathlib import Path
from typing import Self

import numpy as np

import beltsort
from beltsort.cell import Health, Outcome, Scan
from beltsort.cell.commands import TIMEOUT
from beltsort.geometry import BeltLayout
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from tests.sorting.plant import Levels, plant
from tests.sorting.scripted_cell import Glimpsed

MODEL = beltsort.SortingModel.load("tests/fixtures/paper.json").replace(r_min=20)
OBJECTS, SEED = 10, 7


def kill() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


class FileWorld:
    """A cell whose devices remember in a file what they did, whatever becomes of their clients.

    A label is drawn by (seed, object at the belt end, scan since the belt moved, position).
    """

    def __init__(
        self,
        path: Path,
        scans: int = 0,
        kill_at: int | None = None,
        model: beltsort.SortingModel = MODEL,
    ) -> None:
        self.database = sqlite3.connect(path, isolation_level=None)
        self.database.execute(
            "CREATE TABLE IF NOT EXISTS acts "
            "(number INTEGER PRIMARY KEY, id TEXT UNIQUE, name TEXT, target INTEGER)"
        )
        self.scans, self.kill_at = scans, kill_at
        self.p_obs, kinds = model.p_obs, model.p_obs.shape[2]
        self.true = np.random.default_rng(SEED).integers(kinds, size=OBJECTS + 2)
        self.classes, self.viewpoints, self.bin_names = model.classes, model.viewpoints, model.bins
        self.layout = BeltLayout(positions=model.positions)

    reject_bin = None

    @property
    def arm(self) -> Self:
        return self

    camera = belt = sorter = arm

    def health(self) -> Health:
        return Health(ready=True, boot_id="file")

    def stop(self) -> None:
        pass

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        done = self.database.execute("SELECT count(*) FROM acts WHERE id = ?", (command_id,)).fetchone()[0]
        return Outcome.DONE if done else Outcome.NOT_DONE

    @property
    def first(self) -> int:
        """The object at the belt end."""
        return len(self.acts("advance"))

    def acts(self, name: str) -> list[int]:
        rows = self.database.execute("SELECT target FROM acts WHERE name = ? ORDER BY number", (name,))
        return [target for (target,) in rows]

    def _act(self, name: str, target: int, command_id: str) -> float:
        if self.outcome_of(command_id) is Outcome.NOT_DONE:
            number = self.database.execute(
                "INSERT INTO acts (id, name, target) VALUES (?, ?, ?)", (command_id, name, target)
            ).lastrowid
            if number == self.kill_at:
                kill()
        if name == "advance":
            self.scans = 0
        return 0.0

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        return self._act("move", viewpoint, command_id)

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        return self._act("advance", index, command_id)

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        self._act("sort", label, command_id)

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """A scan whose points are the labels: perception reads them back."""
        first, viewpoint = self.first, self.acts("move")[-1]
        labels = []
        for j in range(self.layout.positions):
            rng = np.random.default_rng((SEED, first, self.scans, j))
            chances = self.p_obs[j, viewpoint, self.true[first + j]]
            labels.append(rng.choice(len(chances), p=chances))
        self.scans += 1
        return Scan(np.array([[label, 0.0, 0.0] for label in labels]), np.eye(4), stamp=not_before)


def perceive(scan: Scan) -> list[Glimpsed]:
    return [Glimpsed(label=int(label), empty=False) for label in scan.points[:, 0]]


def planner(model: beltsort.SortingModel = MODEL) -> beltsort.Despot:
    return beltsort.Despot(model, trials=20, scenarios=100, seed=1)


def run(folder: Path, point: str, *, resume: bool, model: beltsort.SortingModel = MODEL) -> SortingReport:
    kind, _, number = point.partition(":")

    def listener(entry: Entry) -> None:
        if kind == "entry" and entry.number == int(number):
            kill()

    path = folder / "journal.sqlite"
    scans = progress_in(path).scans if resume else 0
    world = FileWorld(folder / "world.sqlite", scans, int(number) if kind == "act" else None, model)
    seen = perceive if model is MODEL else Levels()
    with Journal(path, listener, resume=resume) as journal:
        if resume:
            return resume_sorting(world, seen, planner(model), journal)
        return sort_objects(world, seen, planner(model), model, journal, objects=OBJECTS, belt_ends=True)


if __name__ == "__main__":
    model = plant() if "plant" in sys.argv else MODEL
    run(Path(sys.argv[1]), sys.argv[2], resume="resume" in sys.argv, model=model)
