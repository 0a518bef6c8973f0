"""A run of ten objects over ROS 2 that kills itself: `python -m tests.soak.ros2_run FOLDER DOMAIN POINT`.

Belt and sorter are those of a peer (`tests.drivers.ros2.peer`) on the ROS domain. POINT is `entry:N` (when
entry N has been written), `act:N` (when belt or sorter have carried out their N-th command, before it is
written), `during:N` (a moment after it was begun) or `never`.
"""

import signal
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from threading import Timer
from typing import TypeVar

from beltsort.cell import Health, Outcome
from beltsort.cell.commands import TIMEOUT
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from beltsort.cellfile.composed import ComposedCell
from beltsort.drivers.ros2 import Ros2Belt, Ros2Sorter
from beltsort.sorting.holds import Operator, nobody
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from tests.drivers.ros2 import scene
from tests.sorting.killed_run import MODEL, OBJECTS, FileWorld, kill, perceive, planner

MOMENT = 0.1
"""Seconds after the begin of a command at which `during` kills; motions of the peer take longer."""

Result = TypeVar("Result")


class Moments:
    """The moment at which the run kills itself, among those of its commands."""

    def __init__(self, kind: str, number: int) -> None:
        self._kind, self._number, self._acts = kind, number, 0

    def act(self, command: Callable[[], Result]) -> Result:
        self._acts += 1
        now = self._acts == self._number
        if now and self._kind == "during":
            Timer(MOMENT, kill).start()
        result = command()
        if now and self._kind == "during":
            signal.pause()
        if now and self._kind == "act":
            kill()
        return result


class CountingBelt:
    """The belt of ROS 2; the camera of the file counts scans anew when it moves."""

    def __init__(self, device: Ros2Belt, moments: Moments, world: "Eyes") -> None:
        self._device, self._moments, self._world = device, moments, world
        self.health, self.stop = device.health, device.stop
        self.outcome_of, self.position = device.outcome_of, device.position

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        stopped = self._moments.act(partial(self._device.advance_to, index, command_id, timeout=timeout))
        self._world.scans = 0
        return stopped


class CountingSorter:
    """The sorter of ROS 2."""

    def __init__(self, device: Ros2Sorter, moments: Moments) -> None:
        self._device, self._moments = device, moments

    def health(self) -> Health:
        return self._device.health()

    def stop(self) -> None:
        self._device.stop()

    def outcome_of(self, command_id: str, boot_id: str = "", /) -> Outcome:
        return self._device.outcome_of(command_id, boot_id)

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        self._moments.act(partial(self._device.sort, label, command_id, timeout=timeout))


class Eyes(FileWorld):
    """Arm and camera of the file; what stands at the belt end, the belt says."""

    where: Callable[[], int]

    @property
    def first(self) -> int:
        return self.where()


def run(folder: Path, domain: int, point: str, *, resume: bool, operator: Operator = nobody) -> SortingReport:
    kind, _, number = point.partition(":")

    def listener(entry: Entry) -> None:
        if kind == "entry" and entry.number == int(number):
            kill()

    path = folder / "journal.sqlite"
    moments = Moments(kind, int(number or 0))
    eyes = Eyes(folder / "world.sqlite", progress_in(path).scans if resume else 0)
    with Ros2Belt(scene.belt(domain)) as belt, Ros2Sorter(scene.sorter(domain)) as sorter:
        eyes.where = belt.position
        cell = ComposedCell(
            WrappedArm(eyes),
            WrappedCamera(eyes),
            WrappedBelt(CountingBelt(belt, moments, eyes)),
            WrappedSorter(CountingSorter(sorter, moments)),
            *(tuple(MODEL.classes), tuple(MODEL.viewpoints), eyes.layout, None),
        )
        with Journal(path, listener, resume=resume) as journal:
            if resume:
                return resume_sorting(cell, perceive, planner(), journal, operator=operator)
            return sort_objects(cell, perceive, planner(), MODEL, journal, objects=OBJECTS, belt_ends=True)


if __name__ == "__main__":
    run(Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3], resume=False)
    time.sleep(MOMENT)
