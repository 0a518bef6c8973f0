"""What every back-end under contract can do for a test."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np

from beltsort.cell import Belt, Scan, Sorter
from beltsort.errors import CloudError

PATIENCE = 60.0
"""Seconds that a process may take to start or to say something."""


class BeltAndSorter(Belt, Sorter, Protocol):
    """Belt and sorter of one controller."""


class Peer(ABC):
    """A back-end, which `folder` belongs to.

    Its world is what an onlooker sees: the viewpoint of the arm, the object at the belt end, and how many
    objects were sorted.
    """

    actuators: ClassVar[Sequence[str]]
    """Of "arm", "belt" and "sorter"; "arm by action", for example, is another way to command the arm."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @abstractmethod
    def refresh(self) -> None:
        """Make it ready for the next test."""

    @abstractmethod
    def close(self) -> None:
        """End it, whatever state it is in."""

    @abstractmethod
    def ready(self, role: str) -> Any:
        """Return a device that takes commands."""

    @abstractmethod
    def fresh(self, role: str) -> int:
        """Return a target whose command changes the world."""

    @abstractmethod
    def impossible(self, role: str) -> int:
        """Return a target that the device must refuse."""

    @abstractmethod
    def world(self, role: str) -> int:
        """Return the viewpoint, the object at the belt end, or the number of sorted objects."""

    def busy(self, role: str) -> bool:
        """Tell whether a device acts; never, if its acts take no time."""
        return False

    @abstractmethod
    def lose(self, role: str) -> None:
        """Let the next command act without an answer."""

    @abstractmethod
    def fill(self) -> None:
        """Let the next sort find its bin full."""

    @abstractmethod
    def mend(self) -> None:
        """Let the next sort find room in its bin."""

    @abstractmethod
    def heard(self) -> None:
        """Undo `lose`: answers arrive again."""


class SeeingPeer(Peer):
    """A back-end with a camera, whose scans `mend` mends too."""

    def now(self) -> float:
        """Return a time on the cell's clock that scans must not be earlier than."""
        return 0.0

    @abstractmethod
    def spoil(self, kind: str) -> None:
        """Let scans be "stale", "empty", "nan" or "truncated"."""

    def perceive(self, scan: Scan) -> None:
        """Refuse a scan that shows nothing, as perception does."""
        if not np.isfinite(scan.points).any():
            raise CloudError("no point is finite")


class ProcessPeer(Peer):
    """A back-end in a process of its own."""

    @abstractmethod
    def far(self, role: str) -> int:
        """Let the next command take long, and return its target."""

    @abstractmethod
    def kill(self) -> None:
        """Kill it (SIGKILL)."""

    @abstractmethod
    def restart(self) -> None:
        """Start it again after `kill`, its memory wiped."""

    @abstractmethod
    def hang(self) -> None:
        """Stop it (SIGSTOP)."""

    @abstractmethod
    def resume(self) -> None:
        """Let it go on (SIGCONT)."""

    @abstractmethod
    def stick(self) -> None:
        """Let the next advance not move the belt."""

    @abstractmethod
    def looked_at(self, index: int) -> None:
        """Tell a belt that failed which object is at its end."""

    @abstractmethod
    def overshoot(self) -> None:
        """Let the next advance go one object too far."""
