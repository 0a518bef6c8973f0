"""A run on a belt that never stops, over OPC UA: `python -m tests.soak.moving_run FOLDER OBJECTS`.

FOLDER has `options.json`, the options of the connection, and `starts.json`, how far the belt had moved in
the world when each start of its controller began to count, by boot id. The camera renders depth scans of the
world as the belt's encoder says it stands. A call in `EVERY` fails on purpose, which `faults.jsonl` tells.
"""

import json
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from beltsort import MovingBelt, MovingPlanner
from beltsort.cell import BeltReading, CommandError, DiversionStatus, DivertingBelt, Health, Outcome, Scan
from beltsort.cell.commands import TIMEOUT
from beltsort.drivers.opcua import OpcuaOptions, make_diverter
from beltsort.geometry import BeltLayout
from beltsort.models import paper
from beltsort.perception import Perception
from beltsort.sim import BeltDrive, CellConfig, MovingCell
from beltsort.sim.prepare import prepare
from beltsort.sorting.holds import HeldError
from beltsort.sorting.interrupts import Interrupts
from beltsort.sorting.journal import Journal
from beltsort.sorting.moving.loop import resume_moving, sort_moving
from beltsort.sorting.requests import taking_requests
from beltsort.sorting.rules import Rules
from beltsort.tracking import TrackedPerception
from beltsort.util.randomness import generator

SPEED, SEED, EVERY = 0.18, 23, 100
EXPOSURE = 0.02
MOVE = 0.3  # seconds
CONFIG = CellConfig(move_seconds=MOVE, scan_seconds=0.05)
TICKS = 4
"""Ticks of a quarter of a second in which the belt moves on by a place."""

MODEL = paper().replace(r_min=5)
RULES = Rules(retry_delays=(0.1, 0.3, 1.0, 3.0))

Result = TypeVar("Result")


def moving_belt() -> MovingBelt:
    """The model of the belt."""
    moves = [[0 if a == b else 2 for b in range(3)] for a in range(3)]
    seconds = CONFIG.layout.spacing / SPEED / TICKS
    return MovingBelt(
        MODEL, ticks_per_place=TICKS, reach=2, move_ticks=moves, scan_ticks=1, seconds_per_tick=seconds
    )


def true_labels(number: int) -> list[int | None]:
    """The class of each object, None for one empty cup of ten."""
    rng = np.random.default_rng(SEED)
    labels = rng.integers(len(CONFIG.classes), size=number)
    return [None if rng.random() < 0.1 else int(label) for label in labels]


class World(MovingCell):
    """Arm and camera in real time, at a belt that moves as its controller says."""

    def __init__(self, true: list[int | None], eyes: DivertingBelt, starts: Path) -> None:
        super().__init__(true, BeltDrive(SPEED, exposure=EXPOSURE, slices=4), CONFIG, SEED)
        self._eyes, self._starts = eyes, starts
        self._seen = [(0.0, 0.0)] * 2  # time and travel of the last two readings

    @property
    def clock(self) -> float:
        return time.monotonic()

    @clock.setter
    def clock(self, _time: float) -> None:
        pass

    def travel(self, time: float) -> float:
        (t1, a), (t2, b) = self._seen
        return b if t2 <= t1 else a + (b - a) * (time - t1) / (t2 - t1)

    def read(self) -> None:
        """Look how far the belt has moved in the world."""
        reading = self._eyes.reading()
        before = json.loads(self._starts.read_text())[reading.boot_id]
        self._seen = [self._seen[1], (reading.stamp, before + reading.travel)]

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        self._arm = (self._arm[1], viewpoint, self.clock, self.clock + MOVE)
        time.sleep(MOVE)
        return self.clock

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        self.read()
        stamp = max(self.clock, not_before)
        time.sleep(CONFIG.scan_seconds)
        self.read()
        rng = generator(SEED, int(1e6 * stamp))
        return Scan(self._exposed(stamp, rng), self.pose(stamp + EXPOSURE / 2.0), stamp)

    def stop(self) -> None:
        pass


@dataclass
class Faults:
    """Lets one call of `EVERY` fail, and tells it."""

    file: Path
    rng: np.random.Generator

    def call(self, name: str, act: Callable[[], Result], *, lost: bool = True) -> Result:
        """Call a device, unless it fails before or after."""
        with self.file.open("a") as file:
            if self.rng.random() >= 1.0 / EVERY:
                file.write(json.dumps({"call": name}) + "\n")
                return act()
            kind = str(self.rng.choice(["refused", "late", *(["lost"] if lost else [])]))
            file.write(json.dumps({"call": name, "fault": kind}) + "\n")
        match kind:
            case "refused":
                raise CommandError("refused on purpose", Outcome.NOT_DONE)
            case "late":
                time.sleep(0.5)
                return act()
        act()
        raise CommandError("the reply was lost on purpose", Outcome.UNKNOWN)


class FaultyBelt:
    """The belt, of which some calls fail."""

    def __init__(self, belt: DivertingBelt, faults: Faults) -> None:
        self._belt, self._faults = belt, faults
        self.health, self.stop = belt.health, belt.stop

    def reading(self, *, timeout: float = TIMEOUT) -> BeltReading:
        return self._faults.call("reading", lambda: self._belt.reading(timeout=timeout))

    def divert(
        self,
        command_id: str,
        *,
        number: int,
        coordinate: float,
        label: int,
        boot_id: str,
        timeout: float = TIMEOUT,
    ) -> DiversionStatus:
        def act() -> DiversionStatus:
            return self._belt.divert(
                command_id, number=number, coordinate=coordinate, label=label, boot_id=boot_id
            )

        return self._faults.call("divert", act)

    def diversion(self, command_id: str, *, boot_id: str, timeout: float = TIMEOUT) -> DiversionStatus:
        return self._faults.call("diversion", lambda: self._belt.diversion(command_id, boot_id=boot_id))


class FaultyHead:
    """Arm and camera, of which some calls fail."""

    def __init__(self, world: World, faults: Faults) -> None:
        self._world, self._faults = world, faults
        self.stop = world.stop

    def health(self) -> Health:
        return self._world.health()

    def outcome_of(self, command_id: str, boot_id: str = "", /) -> Outcome:
        return self._world.outcome_of(command_id)

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        return self._faults.call("move_to", lambda: self._world.move_to(viewpoint, command_id))

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        return self._faults.call("scan", lambda: self._world.scan(not_before=not_before), lost=False)


class Cell:
    """The cell of the run."""

    def __init__(self, folder: Path, objects: int) -> None:
        options = OpcuaOptions(**json.loads((folder / "options.json").read_text()))
        device = make_diverter(options)  # a controller has one client: the world sees the belt through it too
        self._world = World(true_labels(objects + 200), device, folder / "starts.json")
        faults = Faults(folder / "faults.jsonl", np.random.default_rng((SEED, os.getpid())))
        self.arm = self.camera = FaultyHead(self._world, faults)
        self.belt = FaultyBelt(device, faults)
        self.classes, self.viewpoints = self._world.classes, self._world.viewpoints

    @property
    def layout(self) -> BeltLayout:
        return self._world.layout

    def wait(self, seconds: float) -> None:
        time.sleep(seconds)


def run(folder: Path, objects: int) -> None:
    """Sort, or go on sorting."""
    cell, journal = Cell(folder, objects), folder / "journal.sqlite"
    perceive = TrackedPerception(Perception(cell.layout, prepare().database), EXPOSURE)
    belt, resume = moving_belt(), journal.exists()
    policy = MovingPlanner(belt, trials=3)
    with Interrupts() as interrupts, taking_requests(folder), Journal(journal, resume=resume) as writer:
        if resume:
            resume_moving(
                *(cell, perceive, policy, writer), rules=RULES, check=interrupts.check, requests=folder
            )
        else:
            sort_moving(
                *(cell, perceive, policy, belt, writer),
                objects=objects,
                rules=RULES,
                check=interrupts.check,
                requests=folder,
            )


if __name__ == "__main__":
    try:
        run(Path(sys.argv[1]), int(sys.argv[2]))
    except HeldError as held:
        sys.exit(f"held: {held}")
