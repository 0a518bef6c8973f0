"""A cell and a perception that follow a script, for the rules of the loop."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Self, TypeAlias

import numpy as np

import beltsort
from beltsort.cell.commands import TIMEOUT, Outcome
from beltsort.cell.protocols import Health, Scan
from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout

EMPTY = "empty"
UNUSABLE = "unusable"
Glimpse: TypeAlias = int | str | None
"""A label, None (seen, not labelled) or EMPTY."""


@dataclass(frozen=True)
class Glimpsed:
    label: int | None
    empty: bool

    @property
    def finding(self) -> str:
        return EMPTY if self.empty else "object"


@dataclass
class ScriptedCell:
    """Records its commands; `interrupt_at` raises KeyboardInterrupt in the n-th call."""

    model: beltsort.SortingModel
    reject_bin: int | None = None
    interrupt_at: int | None = None
    acts: list[tuple[str, int]] = field(default_factory=list)
    command_ids: list[str] = field(default_factory=list)
    viewpoint: int = 0
    first: int = 0
    stamps: list[float] = field(default_factory=list)
    stops: int = 0

    @property
    def classes(self) -> Sequence[str]:
        return [name for name in self.model.classes if name != self.model.empty]

    @property
    def viewpoints(self) -> Sequence[str]:
        return self.model.viewpoints

    @property
    def layout(self) -> BeltLayout:
        return BeltLayout(positions=self.model.positions)

    @property
    def arm(self) -> Self:
        return self

    camera = belt = sorter = arm

    def health(self) -> Health:
        return Health(ready=True, boot_id="scripted")

    def stop(self) -> None:
        self.stops += 1

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        return Outcome.DONE if command_id in self.command_ids else Outcome.NOT_DONE

    def _act(self, name: str, target: int, command_id: str) -> None:
        if len(self.acts) == self.interrupt_at:
            raise KeyboardInterrupt
        self.acts.append((name, target))
        self.command_ids.append(command_id)

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        self._act("move", viewpoint, command_id)
        self.viewpoint = viewpoint
        return float(len(self.acts))

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        self.stamps.append(not_before)
        return Scan(np.zeros((1, 3)), np.eye(4), stamp=not_before)

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        self._act("sort", label, command_id)

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        self._act("advance", index, command_id)
        self.first = index
        return float(len(self.acts))


class LookOnce:
    """Looks at each object once, then names what it most likely is."""

    def __init__(self) -> None:
        self.looked = False

    def act(self, belief: beltsort.Belief, viewpoint: int) -> beltsort.Move | beltsort.Decide:
        self.looked = not self.looked
        return beltsort.Move(1) if self.looked else beltsort.Decide(belief.most_likely(0)[0])


def scripted(scans: Iterable[Sequence[Glimpse] | str]) -> Callable[[Scan], list[Glimpsed]]:
    """Return a perception that finds in one scan after the other what the script says."""
    script = iter(scans)

    def perceive(_scan: Scan) -> list[Glimpsed]:
        scan = next(script)
        if scan == UNUSABLE:
            raise CloudError("no point is finite")
        return [Glimpsed(label=what if isinstance(what, int) else None, empty=what == EMPTY) for what in scan]

    return perceive
