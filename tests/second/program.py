"""A run in a process of its own, which can be interrupted and killed."""

import mmap
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from beltsort.cell import Cell, CommandError, EmergencyStopError, Scan
from beltsort.cell.commands import TIMEOUT
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from beltsort.cellfile.composed import ComposedCell
from beltsort.drivers.fieldbus import FieldbusDevice
from beltsort.drivers.modbus import ModbusOptions, make
from beltsort.drivers.opcua import OpcuaOptions
from beltsort.drivers.opcua import make as make_opcua
from beltsort.errors import JournalError
from beltsort.geometry import BeltLayout
from beltsort.models import paper
from beltsort.sorting.holds import Answer, HeldError, Hold, Operator
from beltsort.sorting.interrupts import Interrupted, Interrupts
from beltsort.sorting.journal import Journal
from beltsort.sorting.locks import locked
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Rules
from tests.sorting.killed_run import perceive
from tests.sorting.scripted_cell import LookOnce, ScriptedCell

CLASSES = 4
MODEL = paper().replace(p_obs=np.tile(0.01 + 0.96 * np.eye(CLASSES), (2, 3, 1, 1)), r_min=5)
RULES = Rules(retry_delays=(0.05, 0.1, 0.2, 0.4, 0.8))
JOURNAL = "journal.sqlite"


@dataclass
class World:
    """The file in which the belt and its objects are: `struct world` of controller.c."""

    path: Path
    objects: int = 4096

    def __post_init__(self) -> None:
        size = 8 + 2 * 4 * self.objects
        if not self.path.exists():
            self.path.write_bytes(bytes(size))
        with self.path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), size)

    @property
    def belt(self) -> float:
        """The place at the belt end."""
        return float(struct.unpack_from("<d", self._memory)[0])

    @belt.setter
    def belt(self, place: float) -> None:
        struct.pack_into("<d", self._memory, 0, place)

    def bin(self, number: int) -> int | None:
        """Where an object lies; None: on the belt."""
        lies = int(struct.unpack_from("<i", self._memory, 8 + 4 * number)[0])
        return lies - 1 if lies else None

    def drops(self, number: int) -> int:
        """How often the gripper was opened for an object."""
        return int(struct.unpack_from("<i", self._memory, 8 + 4 * (self.objects + number))[0])


def class_of(number: int) -> int:
    return number % CLASSES


class ClassCamera(ScriptedCell):
    """Arm and camera; sees the true class of whatever stands at the belt end, and behind it."""

    where: Callable[[], int]

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        first = self.where()
        points = [[float(class_of(first + place)), 0.0, 0.0] for place in range(2)]
        return Scan(np.array(points), np.eye(4), stamp=not_before)


class Site(Protocol):
    """Where a controller is reached, and what stands at its belt end."""

    def device(self) -> FieldbusDevice:
        """Return the controller's belt and sorter."""

    def where(self, device: FieldbusDevice) -> int:
        """Return the number of the object at the belt end."""


@dataclass(frozen=True)
class Second:
    """The second controller, in C."""

    port: int
    world: Path

    def device(self) -> FieldbusDevice:
        return make(ModbusOptions("127.0.0.1", self.port, answer_timeout=1.0, allow_insecure=True))

    def where(self, device: FieldbusDevice) -> int:
        return round(World(self.world).belt)


@dataclass(frozen=True)
class Reference:
    """A reference server."""

    options: ModbusOptions | OpcuaOptions

    def device(self) -> FieldbusDevice:
        if isinstance(self.options, ModbusOptions):
            return make(self.options)
        return make_opcua(self.options)

    def where(self, device: FieldbusDevice) -> int:
        return device.position()


def cell_at(site: Site) -> Cell:
    """Return the cell of a controller: arm and camera are imagined, belt and sorter are the controller's."""
    device, camera = site.device(), ClassCamera(MODEL)
    camera.where = partial(site.where, device)
    return ComposedCell(
        WrappedArm(camera),
        WrappedCamera(camera),
        WrappedBelt(device),
        WrappedSorter(device),
        classes=tuple(MODEL.classes),
        viewpoints=tuple(MODEL.viewpoints),
        layout=BeltLayout(positions=MODEL.positions),
        reject_bin=None,
    )


def answering(settle: Answer | None) -> Operator:
    """Return who says once what a person has found, as `beltsort run --settle` does."""
    told = [] if settle is None else [settle]

    def operator(hold: Hold) -> Answer | None:
        if told and told[0] in hold.answers:
            return told.pop()
        raise HeldError(hold)

    return operator


def program(
    folder: Path, site: Site, objects: int, resume: bool, settle: Answer | None, pipe: Connection
) -> None:
    """Sort, or go on, and tell how it ended."""
    with suppress(BrokenPipeError):
        pipe.send(ended(folder, site, objects, resume, settle))


def ended(folder: Path, site: Site, objects: int, resume: bool, settle: Answer | None) -> Any:
    """Return how a run ended: its report, the hold, or the error's name."""
    try:
        with Interrupts() as interrupts, locked("the run", folder / "lock"):
            return sort(folder, site, objects, resume, answering(settle), interrupts)
    except HeldError as held:
        return held.hold
    except (EmergencyStopError, CommandError, Interrupted) as error:
        return type(error).__name__
    except JournalError:  # it was killed before its first entry
        return "anew"


def sort(
    folder: Path, site: Site, objects: int, resume: bool, operator: Operator, interrupts: Interrupts
) -> SortingReport:
    cell = cell_at(site)
    with Journal(folder / JOURNAL, resume=resume) as journal:
        rest: dict[str, Any] = {"rules": RULES, "operator": operator, "check": interrupts.check}
        if resume:
            return resume_sorting(cell, perceive, LookOnce(), journal, **rest)
        return sort_objects(cell, perceive, LookOnce(), MODEL, journal, objects=objects, **rest)
