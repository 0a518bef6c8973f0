"""Faults on purpose: a device that fails as real ones do, as a function of a seed."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from beltsort.cell.commands import CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import Health, Scan
from beltsort.cell.wrappers.wrapped import Act, Call
from beltsort.testing.fault_kinds import COMMANDS, Fault
from beltsort.util.randomness import generator

ON_PURPOSE = "(a fault on purpose: see [faults])"


@dataclass(frozen=True)
class FaultPlan:
    """Which calls fail, and how.

    The n-th call of a command fails as the schedule says; else with the probability of each kind, by a draw
    that depends on the seed, the command and n alone.

    Attributes
    ----------
    seed
        Not negative.
    rates
        Probability per call, by kind.
    schedule
        Kind by command and number of the call, counted from 1.
    """

    seed: int = 0
    rates: Mapping[Fault, float] = field(default_factory=dict)
    schedule: Mapping[tuple[str, int], Fault] = field(default_factory=dict)

    def fault(self, command: str, number: int) -> Fault | None:
        """Return how a call fails, or None."""
        draw = self.generator(command, number).random()
        for kind, rate in self.rates.items():
            if command in kind.befalls:
                if draw < rate:
                    return self.schedule.get((command, number), kind)
                draw -= rate
        return self.schedule.get((command, number))

    def generator(self, command: str, number: int) -> np.random.Generator:
        """Return the random numbers of a call."""
        return generator(self.seed, COMMANDS.index(command), number)


class Faults:
    """Makes devices fail; one for all devices of a cell, as if one controller drove them.

    Parameters
    ----------
    plan
        Which calls fail.
    viewpoints
        Number of viewpoints, at one of which a wrong arrival ends.
    """

    def __init__(self, plan: FaultPlan, viewpoints: int) -> None:
        self._plan, self._viewpoints = plan, viewpoints
        self._calls: Counter[str] = Counter()
        self._boots = 0
        self._known: set[str] = set()
        self._pressed = False
        self._late: tuple[Call, Act] | None = None
        self._last_scan: Scan | None = None

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on, or let it fail."""
        if call.name == "outcome_of":
            return self._outcome(call, act)
        self._catch_up()
        if call.name == "health":
            return self._health(act(call))
        if call.name not in COMMANDS:
            return act(call)
        return self._command(call, act)

    def _command(self, call: Call, act: Act) -> Any:
        if self._pressed:
            raise EmergencyStopError(f"the emergency stop is pressed {ON_PURPOSE}", Outcome.NOT_DONE)
        self._calls[call.name] += 1
        number = self._calls[call.name]
        named = self._named(call)
        match self._plan.fault(call.name, number):
            case None:
                return self._remembered(act(named))
            case Fault.NOT_DONE:
                raise _failure(call, "was refused", Outcome.NOT_DONE)
            case Fault.FULL_BIN:
                raise _failure(call, "found the bin full", Outcome.NOT_DONE)
            case Fault.LOST_ACKNOWLEDGEMENT:
                act(named)
                raise _failure(call, "was not acknowledged", Outcome.UNKNOWN)
            case Fault.LATE:
                self._late = (named, act)
                raise _failure(call, f"did not end within {call.timeout:g} s", Outcome.UNKNOWN)
            case Fault.WRONG_ARRIVAL:
                return act(replace(named, target=(int(call.target or 0) + 1) % self._viewpoints))
            case Fault.EMERGENCY_STOP:
                self._pressed = True
                raise EmergencyStopError(f"the emergency stop was pressed {ON_PURPOSE}", Outcome.NOT_DONE)
            case Fault.RESTART:
                if self._plan.generator(call.name, number).random(2)[1] < 0.5:
                    act(named)
                self._boots += 1
                self._known.clear()
                raise _failure(call, "was cut off by a restart of the controller", Outcome.UNKNOWN)
            case kind:
                return self._spoilt(kind, act(call), call.target or 0.0)

    def _named(self, call: Call) -> Call:
        """Return the call under an id of this boot: a device that forgot a command would act again."""
        if call.command_id is None:
            return call
        self._known.add(call.command_id)
        return replace(call, command_id=self._id(call.command_id))

    def _id(self, command_id: str) -> str:
        return f"{command_id}@{self._boots}" if self._boots else command_id

    def _outcome(self, call: Call, act: Act) -> Outcome:
        late = self._late is not None and self._late[0].command_id == self._id(call.command_id or "")
        self._catch_up()
        if late or (self._boots and call.command_id not in self._known):
            return Outcome.UNKNOWN
        outcome: Outcome = act(replace(call, command_id=self._id(call.command_id or "")))
        return outcome

    def _catch_up(self) -> None:
        """Let a late act happen: nobody waits for it any more."""
        if self._late is not None:
            (call, act), self._late = self._late, None
            try:
                act(call)
            except CommandError:
                return

    def _health(self, health: Health) -> Health:
        if self._boots:
            health = replace(health, boot_id=f"{health.boot_id}, restart {self._boots}")
        if self._pressed:
            self._pressed = False
            return replace(health, ready=False, fault=f"emergency stop {ON_PURPOSE}", emergency_stop=True)
        return health

    def _remembered(self, result: Any) -> Any:
        if isinstance(result, Scan):
            self._last_scan = result
        return result

    def _spoilt(self, kind: Fault, scan: Scan, not_before: float) -> Scan:
        points = scan.points
        match kind:
            case Fault.STALE_SCAN:
                return replace(self._last_scan or scan, stamp=not_before - 1.0)
            case Fault.EMPTY_SCAN:
                points = np.empty((0, 3))
            case Fault.NAN_SCAN:
                points = np.full_like(points, np.nan)
            case Fault.TRUNCATED_SCAN:
                points = points[: len(points) // 3]
        return replace(scan, points=points)


def _failure(call: Call, what: str, outcome: Outcome) -> CommandError:
    return CommandError(f"{call.name} {call.command_id or ''} {what} {ON_PURPOSE}", outcome)
