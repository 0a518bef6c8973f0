"""Fault injection: a layer that makes devices fail, reproducibly from a seed."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from beltsort.cell.commands import CommandError, EmergencyStopError, MoveTo, Outcome
from beltsort.cell.protocols import Health, Scan
from beltsort.cell.wrappers.layer import METHODS, Layer, Request, ScanRequest, Send, Take
from beltsort.geometry import Pose
from beltsort.testing.fault_kinds import COMMANDS, Fault
from beltsort.util.randomness import generator

INJECTED = "(an injected fault: see [faults])"


@dataclass(frozen=True)
class FaultPlan:
    """A plan of the faults to inject.

    The n-th call of a command fails as given by the schedule, otherwise at random with the rate of each kind.
    The random draw depends only on the seed, the command and n.

    Attributes
    ----------
    seed
        Seed, at least 0.
    rates
        Probability per call, by kind of fault.
    schedule
        Kind of fault by (command, number of the call, from 1).
    """

    seed: int = 0
    rates: Mapping[Fault, float] = field(default_factory=dict)
    schedule: Mapping[tuple[str, int], Fault] = field(default_factory=dict)

    def fault(self, command: str, number: int) -> Fault | None:
        """Return the fault of a call, or None."""
        draw = self.generator(command, number).random()
        for kind, rate in self.rates.items():
            if command in kind.affected:
                if draw < rate:
                    return self.schedule.get((command, number), kind)
                draw -= rate
        return self.schedule.get((command, number))

    def generator(self, command: str, number: int) -> np.random.Generator:
        """Return the random number generator of a call."""
        return generator(self.seed, COMMANDS.index(command), number)


class Faults(Layer):
    """A layer that injects faults; one instance for all devices of a cell, as if they had one controller.

    Parameters
    ----------
    plan
        The faults to inject.
    viewpoints
        Number of viewpoints, from which that of a wrong arrival is chosen.
    """

    def __init__(self, plan: FaultPlan, viewpoints: int) -> None:
        self._plan, self._viewpoints = plan, viewpoints
        self._calls: Counter[str] = Counter()
        self._boots = 0
        self._ids_since_boot: set[str] = set()
        self._pressed = False
        self._late: tuple[str | None, Callable[[], object]] | None = None
        self._last_scan: Scan | None = None

    def command(self, send: Send, request: Request) -> float:
        """Send a command, or let it fail; a wrong arrival sends a move to another viewpoint."""
        # A new id after a restart: the wrapped device did not restart and remembers the old one.
        named = replace(request, command_id=self._id(request.command_id))
        name = METHODS[type(request.act)]
        fault = self._next_fault(name, request.command_id, request.timeout, partial(send, named))
        if fault is Fault.WRONG_ARRIVAL:
            named = replace(named, act=MoveTo((request.act.target + 1) % self._viewpoints))
        return send(named)

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Take a scan, or let that fail, or return a faulty one."""
        fault = self._next_fault("scan", None, request.timeout, partial(take, request))
        scan = take(request)
        if fault is not None:
            return self._faulty_scan(fault, scan, request.not_before)
        self._last_scan = scan
        return scan

    def outcome_of(self, ask: Callable[[str], Outcome], command_id: str) -> Outcome:
        """Return the outcome of a command, unknown after a restart of the controller."""
        known_as = self._id(command_id)
        late = self._late is not None and self._late[0] == known_as
        self._execute_late()
        if late or (self._boots and command_id not in self._ids_since_boot):
            return Outcome.UNKNOWN
        return ask(known_as)

    def health(self, ask: Callable[[], Health]) -> Health:
        """Return the health with the current boot id; an emergency stop is reported once, then released."""
        self._execute_late()
        health = ask()
        if self._boots:
            health = replace(health, boot_id=f"{health.boot_id}, restart {self._boots}")
        if self._pressed:
            self._pressed = False
            return replace(health, ready=False, fault=f"emergency stop {INJECTED}", emergency_stop=True)
        return health

    def stop(self, stop: Callable[[], None]) -> None:
        """Stop, after executing the late call."""
        self._execute_late()
        stop()

    def flange_pose(self, ask: Callable[[float], Pose | None], timeout: float) -> Pose | None:
        """Ask, after executing the late call."""
        self._execute_late()
        return ask(timeout)

    def position(self, ask: Callable[[], int | None]) -> int | None:
        """Ask, after executing the late call."""
        self._execute_late()
        return ask()

    def _next_fault(
        self, name: str, command_id: str | None, timeout: float, act: Callable[[], object]
    ) -> Fault | None:
        """Let a call fail if planned; return a fault that affects only its target or its result."""
        self._execute_late()
        if self._pressed:
            raise EmergencyStopError(f"the emergency stop is pressed {INJECTED}", Outcome.NOT_DONE)
        self._calls[name] += 1
        number, what = self._calls[name], f"{name} {command_id or ''}"
        if command_id is not None:
            self._ids_since_boot.add(command_id)
        fault = self._plan.fault(name, number)
        match fault:
            case Fault.NOT_DONE:
                raise CommandError(f"{what} was rejected {INJECTED}", Outcome.NOT_DONE)
            case Fault.FULL_BIN:
                raise CommandError(f"{what} found the bin full {INJECTED}", Outcome.NOT_DONE)
            case Fault.LOST_ACKNOWLEDGEMENT:
                act()
                raise CommandError(f"{what} was not acknowledged {INJECTED}", Outcome.UNKNOWN)
            case Fault.LATE:
                self._late = None if command_id is None else self._id(command_id), act
                raise CommandError(f"{what} did not end within {timeout:g} s {INJECTED}", Outcome.UNKNOWN)
            case Fault.EMERGENCY_STOP:
                self._pressed = True
                raise EmergencyStopError(f"the emergency stop was pressed {INJECTED}", Outcome.NOT_DONE)
            case Fault.RESTART:
                if self._plan.generator(name, number).random(2)[1] < 0.5:
                    act()
                self._boots += 1
                self._ids_since_boot.clear()
                reason = f"{what} was interrupted by a restart of the controller {INJECTED}"
                raise CommandError(reason, Outcome.UNKNOWN)
        return fault

    def _id(self, command_id: str) -> str:
        return f"{command_id}@{self._boots}" if self._boots else command_id

    def _execute_late(self) -> None:
        """Execute the call that timed out, if there is one, and ignore its result."""
        if self._late is not None:
            (_, act), self._late = self._late, None
            try:
                act()
            except CommandError:
                return

    def _faulty_scan(self, fault: Fault, scan: Scan, not_before: float) -> Scan:
        points = scan.points
        match fault:
            case Fault.STALE_SCAN:
                return replace(self._last_scan or scan, stamp=not_before - 1.0)
            case Fault.EMPTY_SCAN:
                points = np.empty((0, 3))
            case Fault.NAN_SCAN:
                points = np.full_like(points, np.nan)
            case Fault.TRUNCATED_SCAN:
                points = points[: len(points) // 3]
        return replace(scan, points=points)
