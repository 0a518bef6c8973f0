"""A simulated cell with a moving belt whose labels are drawn from the model's tables, and its controller."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from beltsort._core import SortingModel
from beltsort.cell import BeltReading, CommandError, Diversion, DiversionStatus, Health, Outcome, Scan
from beltsort.drivers.fieldbus.diversions import (
    DIVERSION_EXPLANATIONS,
    DiversionPhase,
    DiversionReason,
    DiversionReply,
    DiversionRequest,
    DiversionVerb,
)
from beltsort.drivers.fieldbus.wire import key_of
from beltsort.geometry import BeltLayout, Points
from beltsort.perception import Finding, Perceived
from beltsort.sim import BeltDrive, CellConfig, MovingCell
from beltsort.testing.diverting import DivertingController, DivertingMachine
from beltsort.tracking import Sighting, TrackedLook, TrackedScan, Tracker

STATES = {
    DiversionPhase.QUEUED: Diversion.QUEUED,
    DiversionPhase.DONE: Diversion.DONE,
    DiversionPhase.NOT_DONE: Diversion.NOT_DONE,
    DiversionPhase.TOO_LATE: Diversion.TOO_LATE,
    DiversionPhase.UNKNOWN: Diversion.UNKNOWN,
}


class Unrendered(MovingCell):
    """A moving cell whose scans show nothing: labels come from elsewhere."""

    def _exposed(self, stamp: float, rng: np.random.Generator) -> Points:
        return np.zeros((1, 1, 3))


class SimulatedBelt:
    """Belt and diverters of a simulated cell, on its clock, without a network."""

    def __init__(self, cell: MovingCell, machine: DivertingMachine) -> None:
        self.cell, self.machine, self.boots = cell, machine, 0
        self.unreachable: Callable[[str], bool] = lambda what: False
        self.lost: Callable[[str], bool] = lambda what: False
        self.restart()

    def restart(self) -> None:
        """Start the controller anew: it forgets everything, and its encoder begins at 0."""
        self.boots += 1
        self.began = self.cell.travel(self.cell.clock)
        self.controller = DivertingController(self.machine, self.boots, lambda: self.cell.clock)

    def _ask(self, verb: DiversionVerb, **fields: int) -> DiversionReply:
        if self.unreachable(verb.name):
            raise CommandError("the controller cannot be reached", Outcome.NOT_DONE)
        request = DiversionRequest(self.controller.sequence + 1, verb, **fields)
        reply = self.controller.answer(request)
        if self.lost(verb.name):
            raise CommandError("the reply was lost", Outcome.UNKNOWN)
        return reply

    def health(self) -> Health:
        reply = self._ask(DiversionVerb.LOOK)
        return Health(ready=True, boot_id=str(reply.boot), emergency_stop=reply.emergency_stop)

    def stop(self) -> None:
        self._ask(DiversionVerb.STOP)
        self.cell.set_speed(0.0)

    def start(self) -> None:
        """Start the belt, as an operator does."""
        self.controller.start()
        self.cell.set_speed(self.machine.speed / 1e6)

    def reading(self, *, timeout: float = 1.0) -> BeltReading:
        reply = self._ask(DiversionVerb.LOOK)
        return BeltReading(
            self.cell.clock, reply.position / 1e6, str(reply.boot), reply.moving, reply.emergency_stop
        )

    def divert(
        self,
        command_id: str,
        *,
        number: int,
        coordinate: float,
        label: int,
        boot_id: str,
        timeout: float = 1.0,
    ) -> DiversionStatus:
        reply = self._ask(
            DiversionVerb.DIVERT,
            key=key_of(command_id),
            object=number,
            coordinate=round(1e6 * coordinate),
            bin=label,
            boot=int(boot_id),
        )
        final = (DiversionReason.NONE, DiversionReason.OTHER_COMMAND, DiversionReason.ALREADY_DIVERTED)
        retry = reply.phase is DiversionPhase.NOT_DONE and reply.reason not in final
        return self._status(reply, retry=retry)

    def diversion(self, command_id: str, *, boot_id: str, timeout: float = 1.0) -> DiversionStatus:
        reply = self._ask(DiversionVerb.RECALL, key=key_of(command_id))
        if reply.phase is DiversionPhase.UNKNOWN and (str(reply.boot), reply.forgotten) == (boot_id, 0):
            return DiversionStatus(Diversion.NOT_DONE, boot_id, "it never arrived", retry=True)
        return self._status(reply)

    def _status(self, reply: DiversionReply, *, retry: bool = False) -> DiversionStatus:
        why = "" if reply.reason is DiversionReason.NONE else DIVERSION_EXPLANATIONS[reply.reason]
        return DiversionStatus(STATES[reply.phase], str(reply.boot), why, retry)

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
        diverters = tuple(round(1e6 * (0.5 + 0.3 * n)) for n in range(len(self.classes)))
        self.machine = DivertingMachine(diverters=diverters, speed=round(1e6 * self.speed))
        self.belt = SimulatedBelt(self.world, self.machine)

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
        """Return the class of an object; coordinates begin anew with every start of the controller."""
        return self.true_class(round((coordinate + self.belt.began) / self.layout.spacing))

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
