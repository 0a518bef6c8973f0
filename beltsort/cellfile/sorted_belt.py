"""One simulated belt of a cell file with [moving], sorted from depth scans, for a study of throughput."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from beltsort import MovingBelt, SortingModel
from beltsort.cellfile.composed_moving import compose_moving
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.moving import Moving
from beltsort.cellfile.moving_run import MovingRun
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.results import confusion_of_moving
from beltsort.cellfile.roles import TABLES
from beltsort.cellfile.sections import DeviceSection
from beltsort.cellfile.simulated import NAME, config_of_cell, not_simulated, options_of_cell, true_labels
from beltsort.perception import Classifier, perception_for
from beltsort.planning.bins import Counts
from beltsort.planning.named_moving_policy import named_moving_policy
from beltsort.planning.policy import MovingPolicy, Policy
from beltsort.planning.stop_and_go import StopAndGo
from beltsort.sim.cell import SimulatedCell
from beltsort.sorting.entries import Chosen, Planned, Scanned
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.moving.entries import Looked
from beltsort.sorting.moving.reading import moving_state_in


@dataclass(frozen=True)
class SimulatedBelt:
    """A belt that is to be sorted.

    Attributes
    ----------
    description
        The cell file, with the belt's speed.
    policy
        Name of the policy.
    objects
        Number of cups.
    seed
        Seed of the objects and of the noise.
    model, classifier
        Those of the cell.
    """

    description: CellDescription
    policy: str
    objects: int
    seed: int
    model: SortingModel
    classifier: Classifier


@dataclass(frozen=True, eq=False)
class SortedBelt:
    """What became of the objects of a belt; empty cups are not counted.

    Attributes
    ----------
    confusion
        Objects in bins by bin and true class, shape (B, L).
    missed
        Objects that came into no bin, by true class, shape (L,).
    looks
        Labels that objects got.
    motion_cost
        Sum of the costs of moves.
    seconds
        Time in which the objects passed the exit; with stop-and-go, in which they were sorted.
    plan_seconds
        Wall-clock time of each plan.
    """

    confusion: Counts
    missed: Counts
    looks: int
    motion_cost: float
    seconds: float
    plan_seconds: tuple[float, ...]


def simulated_moving(description: CellDescription) -> Moving:
    """Return the table [moving] of a cell file of which all devices are simulated.

    Raises
    ------
    CellFileError
        If it has no [moving], or a device is not simulated.
    """
    if description.moving is None:
        raise CellFileError.of(
            "moving", "is missing, expected the table of a belt that never stops: see docs/moving.md"
        )
    if others := not_simulated(description):
        raise CellFileError.of(
            "", f"{', '.join(others)} is not {NAME}, expected all devices to be: give a simulated cell"
        )
    return description.moving


def belt_and_policy(
    description: CellDescription, name: str, model: SortingModel
) -> tuple[MovingBelt, MovingPolicy]:
    """Return the belt of a cell file with [moving], and the policy with a name.

    Raises
    ------
    BeltsortError
        As `beltsort.MovingBelt` and `named_moving_policy`.
    """
    belt = simulated_moving(description).belt(model)
    return belt, named_moving_policy(name, belt, description.path(""))[1]


def seeded(description: CellDescription, objects: int, seed: int) -> CellDescription:
    """Return the cell file of a simulated cell with a number of objects and a seed."""

    def device(role: str) -> DeviceSection:
        section = description.device(role)
        return section.model_copy(update={"options": {**section.options, "seed": seed}})

    devices = {TABLES[role]: device(role) for role in description.roles}
    return description.model_copy(update={"objects": objects, **devices})


def sort_belt(work: SimulatedBelt) -> SortedBelt:
    """Sort a belt: as `beltsort run` does, or with stop-and-go on one that stands while the camera looks."""
    belt, policy = belt_and_policy(work.description, work.policy, work.model)
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(policy, StopAndGo):
            return _sort_standing(work, belt, policy.policy, Path(folder))
        return _sort_moving(work, belt, policy, Path(folder))


def _sort_moving(work: SimulatedBelt, belt: MovingBelt, policy: MovingPolicy, folder: Path) -> SortedBelt:
    description = seeded(work.description, work.objects, work.seed)
    cell = compose_moving(description, live=False, say=print)
    report = MovingRun(description, cell, belt, work.classifier, policy, work.policy, folder).sort()
    lattice = moving_state_in(folder / JOURNAL).lattice
    assert lattice is not None  # a run has an end only where cups were seen
    true = [cell.true_class_at(lattice.coordinate(number)) for number in range(work.objects)]
    place = (belt.ticks_per_place or 1) * (belt.seconds_per_tick or 1.0)
    return _counted(work, folder, confusion_of_moving(report), true, work.objects * place)


def _sort_standing(work: SimulatedBelt, belt: MovingBelt, policy: Policy, folder: Path) -> SortedBelt:
    """Sort a belt that stands while the camera looks: the same arm, scans and rules, and the same objects."""
    description, tick = work.description, belt.seconds_per_tick or 1.0
    config = replace(
        config_of_cell(description),
        move_seconds=tuple(tuple(row) for row in (belt.look_ticks * tick).tolist()),
        sort_seconds=0.0,
        advance_seconds=(belt.ticks_per_place or 1) * tick,
    )
    labels = true_labels(replace(options_of_cell(description), seed=work.seed), description)
    first = list(islice(labels, work.objects))
    cell = SimulatedCell(first, config, work.seed, bin_names=description.bin_names, further=labels)
    perceive = perception_for(work.model, cell.layout, work.classifier, description.perception)
    with Journal(folder / JOURNAL) as journal:
        report = sort_objects(
            cell, perceive, policy, work.model, journal, objects=work.objects, rules=description.rules
        )
    found = report.counts.confusion or np.zeros((len(work.model.bins), len(work.model.classes)))
    return _counted(work, folder, np.array(found, dtype=np.uint64), first, cell.clock)


def _counted(
    work: SimulatedBelt, folder: Path, confusion: Counts, true: Sequence[int | None], seconds: float
) -> SortedBelt:
    """Return what a run came to, from what is in the bins, its journal and the true class of each object."""
    costs = work.model.motion_cost
    looks, motion_cost, viewpoint = 0, 0.0, 0
    plan_seconds = []
    for entry in read_journal(folder / JOURNAL):
        match entry.content:
            case Looked(seen=seen):
                looks += sum(each.label is not None for each in seen)
            case Scanned(labels=labels):
                looks += sum(label is not None for label in labels)
            case Planned() | Chosen() as taken:
                if isinstance(taken, Planned):
                    plan_seconds.append(taken.seconds)
                if (goal := taken.action.get("move")) is not None:
                    motion_cost += float(costs[viewpoint, goal])
                    viewpoint = goal
            case _:
                pass
    classes = len(work.model.classes)
    there = np.bincount([label for label in true if label is not None], minlength=classes)
    # At least 0 also where tracking has confused an object with one that is not among these.
    missed = np.maximum(0, there - confusion.sum(axis=0).astype(np.int64)).astype(np.uint64)
    return SortedBelt(confusion, missed, looks, motion_cost, seconds, tuple(plan_seconds))
