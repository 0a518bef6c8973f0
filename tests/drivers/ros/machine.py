"""The arm, belt and sorter of the peers on ROS 1 and ROS 2; needs the standard library only.

A peer is told what to do by lines of JSON, the fields of `Settings`. Each line is answered by one that tells
the state of the world, and how many times the peer has published.
"""

import json
import os
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

BEAT = 0.02
"""Seconds between messages."""

HOME = {"shoulder": 0.0, "elbow": 0.0}
BINS = 5
ACTIVE, SUCCEEDED, ABORTED, REJECTED = "active", "succeeded", "aborted", "rejected"


@dataclass
class Settings:
    cloud: str = "good"
    """What scans are: good, stale, ahead, empty, nan, truncated, silent, or of another frame ("frame")."""
    offset: float = 0.0
    """Radians by which the arm misses its target."""
    speed: float = 5.0
    """Radians a second."""
    verdict: int = 3
    """How a goal ends, a number of ROS 1's GoalStatus."""
    plan: float = 0.0
    """Seconds for which a motion is planned, where it is."""
    travel: float = 0.15
    """Seconds of an advance."""
    emergency: bool = False
    """Whether the emergency stop is pressed."""
    sort: float = 0.1
    """Seconds of a sort."""
    full: bool = False
    """Whether the sorter's bins are."""
    stuck: bool = False
    """Whether the belt does not move."""
    overshoot: bool = False
    """Whether it goes one object too far."""
    mute: bool = False
    """Whether the peer acts on the next command, but reports nothing from then on."""
    unanswered: bool = False
    """Whether services do not answer, though the peer reports."""


class Press:
    """A sorter: it acts on a key once, and shows what became of each."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._verdicts: dict[str, tuple[str, str]] = {}
        self._acting: tuple[str, int] | None = None
        self._ends = 0.0
        self.bins = [0] * BINS

    @property
    def busy(self) -> bool:
        return self._acting is not None

    def told(self, key: str, label: int) -> None:
        if key not in self._verdicts:
            self._verdicts[key] = self._begin(key, label)

    def halt(self) -> None:
        if self._acting is not None:
            self._verdicts[self._acting[0]] = (ABORTED, "stopped on the way")
            self._acting = None

    def beat(self) -> None:
        if self._acting is not None and time.monotonic() >= self._ends:
            (key, label), self._acting = self._acting, None
            self.bins[label] += 1
            self._verdicts[key] = (SUCCEEDED, "")

    def report(self) -> list[tuple[str, str, str]]:
        """Return key, state and explanation of each."""
        return [(key, *verdict) for key, verdict in list(self._verdicts.items())]

    def _begin(self, key: str, label: int) -> tuple[str, str]:
        if not 0 <= label < BINS:
            return REJECTED, f"there is no bin {label}"
        if self._settings.full:
            return REJECTED, "the bin is full"
        self._acting, self._ends = (key, label), time.monotonic() + self._settings.sort
        return ACTIVE, ""


class Machine:
    def __init__(self) -> None:
        self.settings = Settings()
        self.joints = dict(HOME)
        self.target = dict(HOME)
        self.object, self.arrives = 0, 0.0
        self.press = Press(self.settings)
        self.told = False
        self.beats = 0

    def go(self, names: Sequence[str], positions: Sequence[float]) -> None:
        self.told = True
        self.target = {
            name: float(at) + self.settings.offset for name, at in zip(names, positions, strict=True)
        }

    def halt(self) -> None:
        """Stop arm and belt where they are; a belt that stands remains at its object."""
        self.target = dict(self.joints)
        if time.monotonic() < self.arrives:
            self.arrives = float("inf")

    def sort(self, key: str, label: int) -> None:
        self.told = True
        self.press.told(key, label)

    def advance(self, index: int) -> None:
        self.told = True
        if not self.settings.stuck:
            self.object = index + self.settings.overshoot
            self.arrives = time.monotonic() + self.settings.travel

    @property
    def arrived(self) -> bool:
        return self.joints == self.target

    @property
    def belt(self) -> int:
        """What the belt reports."""
        return self.object if time.monotonic() >= self.arrives else -1

    def beat(self) -> bool:
        """Go on by a beat; return whether the peer may report."""
        self.beats += 1
        step = self.settings.speed * BEAT
        for name, at in self.target.items():
            self.joints[name] += min(max(at - self.joints[name], -step), step)
        self.press.beat()
        self.told &= self.settings.mute
        return not self.told

    def world(self) -> Mapping[str, Any]:
        """What an onlooker sees."""
        travelling = time.monotonic() < self.arrives
        return {
            "joints": self.joints,
            "object": self.object,
            "bins": self.press.bins,
            "busy": {"arm": not self.arrived, "belt": travelling, "sorter": self.press.busy},
            "halted": self.arrives == float("inf"),
            "beats": self.beats,
        }


def run(machine: Machine, beat: Callable[[int], object]) -> None:
    """Beat, and listen to what the peer is told, until nobody is left who could tell it anything."""

    def listen() -> None:
        known = {field.name for field in fields(Settings)}
        for line in sys.stdin:
            for name, value in json.loads(line).items():
                assert name in known
                setattr(machine.settings, name, value)
            print(json.dumps(machine.world()), flush=True)
        os._exit(0)  # tests that were killed leave no peer behind, which would answer later ones

    threading.Thread(target=listen, daemon=True).start()
    n = 0
    while True:
        beat(n)
        if n == 0:
            print("ready", flush=True)
        n += 1
        time.sleep(BEAT)
