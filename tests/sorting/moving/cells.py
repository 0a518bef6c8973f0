"""A simulated cell with a moving belt whose labels are drawn from the model's tables, and its controller."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from beltsort._core import SortingModel
from beltsort.cell import Scan
from beltsort.cellfile.simulated_moving import SimulatedDiverters, diverters
from beltsort.drivers.fieldbus.diversions import (
    DiversionPhase,
    DiversionReply,
    DiversionRequest,
    DiversionVerb,
)
from beltsort.geometry import BeltLayout, Points
from beltsort.perception import Finding, Perceived
from beltsort.sim import BeltDrive, CellConfig, MovingCell
from beltsort.testing.diverting import DivertingMachine
from beltsort.tracking import Sighting, TrackedLook, TrackedScan, Tracker


class Unrendered(MovingCell):
    """A moving cell whose scans show nothing: labels come from elsewhere. Its arm does not stop the belt."""

    def stop(self) -> None:
        pass

    def _exposed(self, stamp: float, rng: np.random.Generator) -> Points:
        return np.zeros((1, 1, 3))


class FaultyBelt(SimulatedDiverters):
    """Belt and diverters over a network that loses requests and replies."""

    def __init__(self, cell: MovingCell, machine: DivertingMachine) -> None:
        self.unreachable: Callable[[str], bool] = lambda what: False
        self.lost: Callable[[str], bool] = lambda what: False
        self.slipped = 0.0
        """How far the encoder has jumped, metres."""
        super().__init__(cell, machine)

    def answer(self, request: DiversionRequest) -> DiversionReply:
        verb = DiversionVerb(request.verb).name
        if self.unreachable(verb):
            raise ConnectionError("the request was lost")
        reply = super().answer(request)
        reply = replace(reply, position=reply.position + round(self.slipped * 1e6))
        if self.lost(verb):
            raise ConnectionError("the reply was lost")
        return reply

    @property
    def in_bins(self) -> dict[int, int]:
        """The bin of each object that was diverted since the start, by the number of its cup."""
        spacing = self.cell.layout.spacing
        return {
            round((entry.coordinate / 1e6) / spacing): entry.bin
            for entry in self.controller._memory.values()
            if entry.phase is DiversionPhase.DONE
        }


@dataclass
class MovingPlant:
    """A cell on a belt that never stops, and what is true of it."""

    model: SortingModel
    true_labels: Sequence[int | None]
    speed: float = 0.1
    seed: int = 0
    looks: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.arm = self.camera = self.world = Unrendered(
            self.true_labels, BeltDrive(belt_speed=self.speed), CellConfig(), self.seed
        )
        self.machine = diverters(self.speed, len(self.classes))
        self.belt = FaultyBelt(self.world, self.machine)

    @property
    def classes(self) -> Sequence[str]:
        return self.world.classes

    @property
    def viewpoints(self) -> Sequence[str]:
        return self.world.viewpoints

    @property
    def layout(self) -> BeltLayout:
        return self.world.layout

    @property
    def labels(self) -> Sequence[str]:
        return self.model.labels

    def wait(self, seconds: float) -> None:
        self.world.wait(seconds)

    def true_class(self, index: int) -> int | None:
        return self.world.true_class(index)

    def true_class_at(self, coordinate: float) -> int | None:
        return self.belt.true_class_at(coordinate)

    def perceive(self, scan: Scan, tracker: Tracker) -> TrackedScan:
        """Label every object in view as the tables say, the n-th look at it always by the same random."""
        viewpoint = self.world._arm[1]
        half = self.layout.spacing / 2.0
        places = [
            (number, x)
            for number, x in sorted(self.world.on_belt(scan.stamp).items())
            if -half < x < half + (self.layout.positions - 1) * self.layout.spacing
        ]
        seen, sightings = [], []
        for number, x in places:
            true, place = self.true_class(number), int((x + half) // self.layout.spacing)
            if true is None:
                seen.append(Perceived(place, None, finding=Finding.EMPTY))
            else:
                look = self.looks[number] = self.looks.get(number, 0) + 1
                u = np.random.default_rng((self.seed, number, look)).random()
                odds = np.cumsum(self.model.p_obs[place, viewpoint, true])
                seen.append(Perceived(place, None, label=int(np.searchsorted(odds, u * odds[-1]))))
            sightings.append(Sighting(x, seen[-1].finding))
        update = tracker.update(scan.stamp, sightings)
        looks = zip([x for _, x in places], update.tracks, seen, strict=True)
        return TrackedScan(tuple(TrackedLook(*look) for look in looks), update)


@dataclass
class Perception:
    """The plant's labels as the loop takes them."""

    plant: MovingPlant

    @property
    def labels(self) -> Sequence[str]:
        return self.plant.labels

    def __call__(self, scan: Scan, tracker: Tracker) -> TrackedScan:
        return self.plant.perceive(scan, tracker)
