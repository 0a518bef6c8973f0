"""The simulated cell whose belt never stops, and its controller, without a network."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from beltsort.cell.commands import TIMEOUT
from beltsort.cell.diverting import BeltReading, Diversion, DiversionStatus
from beltsort.cell.protocols import Health
from beltsort.drivers.fieldbus.diversions import DiversionReply, DiversionRequest, DiversionVerb
from beltsort.drivers.fieldbus.diverting_device import MICRO, DivertingDevice
from beltsort.drivers.fieldbus.wire import key_of
from beltsort.sim.belt_drive import BeltDrive
from beltsort.sim.config import CellConfig
from beltsort.sim.moving_cell import MovingCell
from beltsort.sorting.moving.entries import BeltObject, Looked
from beltsort.sorting.moving.state import MovingState
from beltsort.testing.diverting import DivertingController, DivertingMachine

FIRST_DIVERTER, DIVERTER_SPACING = 0.5, 0.3
"""Distance of the first diverter from the belt end, and between two of them, metres."""

ANSWER_TIMEOUT = 60.0
"""Real time that the controller may take to answer, seconds: it is in this process."""


def diverters(speed: float, bins: int) -> DivertingMachine:
    """Return a belt of a speed, metres per second, with diverters for a number of bins."""
    places = tuple(round((FIRST_DIVERTER + n * DIVERTER_SPACING) / MICRO) for n in range(bins))
    return DivertingMachine(diverters=places, speed=round(speed / MICRO))


class SimulatedDiverters(DivertingDevice):
    """Belt and diverters of a `MovingCell`: the reference controller, on the cell's clock.

    Parameters
    ----------
    cell
        The cell, whose belt moves as fast as the machine's.
    machine
        Belt and diverters.

    Attributes
    ----------
    controller
        The controller.
    boots
        How often it was started.
    began
        How far the belt of the cell had moved when it was last started, metres.
    """

    def __init__(self, cell: MovingCell, machine: DivertingMachine) -> None:
        self.cell, self.machine, self.boots = cell, machine, 0
        super().__init__(lambda _timeout: _Wire(self), "the simulation", ANSWER_TIMEOUT, lambda: cell.clock)
        self.restart()

    def restart(self) -> None:
        """Start the controller anew: it forgets everything, and its encoder begins at 0."""
        self.boots += 1
        self.began = self.cell.travel(self.cell.clock)
        self.controller = DivertingController(self.machine, self.boots, lambda: self.cell.clock)

    def answer(self, request: DiversionRequest) -> DiversionReply:
        """Execute a request and return the reply."""
        return self.controller.answer(request)

    def stop(self) -> None:
        """Stop the belt."""
        super().stop()
        self.cell.set_speed(0.0)

    def start(self) -> None:
        """Start the belt, as an operator does."""
        self.controller.start()
        self.cell.set_speed(self.machine.speed * MICRO)

    def resume(self, queued: Mapping[int, BeltObject]) -> None:
        """Bring the controller to the state of a run that is resumed, after the cell has taken it.

        Parameters
        ----------
        queued
            The objects whose diversions are queued, by the controller's number of them.
        """
        clock, speed = self.cell.clock, self.machine.speed * MICRO
        self.cell.clock = clock - self.cell.travel(clock) / speed  # when the encoder was at 0
        self.began = 0.0
        self.controller = DivertingController(self.machine, self.boots, lambda: self.cell.clock)
        self.cell.clock = clock
        for number, known in queued.items():
            assert known.command_id is not None
            assert known.coordinate is not None
            assert known.bin is not None
            self.controller.answer(
                DiversionRequest(
                    self.controller.sequence + 1,
                    DiversionVerb.DIVERT,
                    key=key_of(known.command_id),
                    object=number,
                    coordinate=round(known.coordinate / MICRO),
                    bin=known.bin,
                    boot=self.boots,
                )
            )

    def true_class_at(self, coordinate: float) -> int | None:
        """Return the class index of the object at a coordinate; None for an empty cup."""
        return self.cell.true_class(max(0, round((coordinate + self.began) / self.cell.layout.spacing)))


class _Wire:
    """A connection to the controller: a `Link`."""

    def __init__(self, belt: SimulatedDiverters) -> None:
        self._belt = belt
        self._reply = belt.controller.answer(DiversionRequest(belt.controller.sequence, DiversionVerb.LOOK))

    def write(self, request: DiversionRequest) -> None:
        self._reply = self._belt.answer(request)

    def read(self) -> DiversionReply:
        return self._reply

    def close(self) -> None:
        pass


class SimulatedDivertingCell(MovingCell):
    """A simulated cell whose belt never stops, as arm, camera and belt.

    Parameters
    ----------
    labels
        Class index of each object, None for an empty cup, without end.
    machine
        Belt and diverters.
    drive
        Places of cups and exposure; its speed is the machine's.
    config
        Configuration of the cell.
    seed
        Seed of the objects and of the noise.
    """

    def __init__(
        self,
        labels: Iterator[int | None],
        machine: DivertingMachine,
        drive: BeltDrive,
        config: CellConfig,
        seed: int,
    ) -> None:
        drive = replace(drive, belt_speed=machine.speed * MICRO)
        super().__init__((), drive, config, seed, further=labels)
        self.diverters = SimulatedDiverters(self, machine)

    def health(self) -> Health:
        """Return the controller's health."""
        return self.diverters.health()

    def stop(self) -> None:
        """Stop the belt."""
        self.diverters.stop()

    def reading(self, *, timeout: float = TIMEOUT) -> BeltReading:
        """Return how far the belt has moved."""
        return self.diverters.reading(timeout=timeout)

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
        """Queue a diversion."""
        return self.diverters.divert(
            command_id, number=number, coordinate=coordinate, label=label, boot_id=boot_id, timeout=timeout
        )

    def diversion(self, command_id: str, *, boot_id: str, timeout: float = TIMEOUT) -> DiversionStatus:
        """Return the state of a diversion."""
        return self.diverters.diversion(command_id, boot_id=boot_id, timeout=timeout)

    def resume(self, state: MovingState, last: Looked) -> None:
        """Take the state of a run that is resumed, as of its last scan; the belt moves.

        Parameters
        ----------
        state
            What the run knows.
        last
            Its last scan.
        """
        self.begin_at(last.stamp, last.travel, viewpoint=state.viewpoint, scans=state.scans)
        assert state.lattice is not None  # a scan was used
        queued = {
            state.lattice.mark(number): known
            for number, known in state.diversions.items()
            if known.state == Diversion.QUEUED.value
        }
        self.diverters.resume(queued)

    def true_class_at(self, coordinate: float) -> int | None:
        """Return the class index of the object at a coordinate; None for an empty cup."""
        return self.diverters.true_class_at(coordinate)
