"""The simulated cell, and runs on its belt."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from beltsort import MovingBelt, SortingModel
from beltsort.cellfile.simulated_moving import SimulatedDiverters, diverters
from beltsort.perception import Classifier, Perception
from beltsort.planning.policy import MovingPolicy
from beltsort.sim import BeltDrive, CellConfig, MovingCell
from beltsort.sorting.journal import Journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.moving.looking import PerceiveMoving
from beltsort.sorting.moving.loop import sort_moving
from beltsort.sorting.moving.report import MovingReport
from beltsort.tracking import TrackedPerception

OBJECTS = 20
EXPOSURE = 0.03  # seconds
JITTER = 0.008  # metres, of the cups' places
EMPTY = 0.1  # share of empty cups
ADVANCE = 1.5  # seconds of an advance of the belt that stops
TICK = 0.25  # seconds, about
DISCOUNT = 0.99  # per tick
SCAN = 0.25  # seconds from the exposure's start to the labels
CONFIG = replace(CellConfig(), scan_seconds=SCAN, sort_seconds=0.0, advance_seconds=ADVANCE)


class Cell:
    """Arm, camera and belt of one simulated cell."""

    def __init__(self, belt: int, speed: float) -> None:
        drive = BeltDrive(speed, JITTER, exposure=EXPOSURE)
        self.arm = self.camera = self.world = MovingCell(labels_of(belt), drive, CONFIG, belt)
        self.belt = SimulatedDiverters(self.world, diverters(speed, len(CONFIG.classes)))
        self.classes, self.viewpoints = self.world.classes, self.world.viewpoints
        self.layout, self.true_class_at = self.world.layout, self.belt.true_class_at
        self.wait = self.world.wait

    def perception(self, classifier: Classifier) -> TrackedPerception:
        """Return what perceives its scans."""
        return TrackedPerception(Perception(self.layout, classifier), EXPOSURE)


def labels_of(belt: int) -> list[int | None]:
    """The true classes of a belt's objects, None for an empty cup; some cups follow those that count."""
    rng = np.random.default_rng(belt)
    drawn = rng.integers(len(CONFIG.classes), size=OBJECTS + 3)
    return [None if rng.random() < EMPTY else int(label) for label in drawn]


def moving_model(model: SortingModel, speed: float) -> MovingBelt:
    """The model of a belt of that speed, with the arm's times."""
    config = CONFIG
    per_place = max(1, round(config.layout.spacing / speed / TICK))
    move = math.ceil(config.seconds_of_move(0, 1) / TICK)
    viewpoints = len(config.viewpoints)
    moves = [[0 if a == b else move for b in range(viewpoints)] for a in range(viewpoints)]
    # The tick is such that so many of them are exactly a place.
    tick = config.layout.spacing / speed / per_place
    return MovingBelt(
        model.replace(discount=DISCOUNT),
        ticks_per_place=per_place,
        reach=model.positions,
        move_ticks=moves,
        scan_ticks=math.ceil(SCAN / TICK),
        seconds_per_tick=tick,
    )


def run_belt(
    cell: Cell, perceive: PerceiveMoving, policy: MovingPolicy, moving: MovingBelt, folder: Path
) -> MovingReport:
    """Sort one belt; the journal stays in the folder."""
    with Journal(folder / JOURNAL) as journal:
        return sort_moving(cell, perceive, policy, moving, journal, objects=OBJECTS)
