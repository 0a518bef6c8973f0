"""The results of runs: a CSV file, and a table of it."""

import csv
import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

WHOLE = ("belt", "objects", "right", "wrong", "missed", "empty", "looks")


@dataclass(frozen=True)
class Row:
    """What one belt came to under one policy at one speed (metres per second; 0: stop-and-go)."""

    speed: float
    policy: str
    belt: int
    objects: int
    right: int
    wrong: int
    missed: int
    empty: int
    looks: int
    seconds: float
    plan_p99: float
    tick: float

    @classmethod
    def of(cls, line: Mapping[str, str]) -> "Row":
        """Return a row of a file."""
        whole = {name: int(line[name]) for name in WHOLE}
        real = {name: float(line[name]) for name in ("speed", "seconds", "plan_p99", "tick")}
        return cls(policy=line["policy"], **whole, **real)  # type: ignore[arg-type] # the fields by type

    @property
    def objects_seen(self) -> int:
        """Cups that were not empty."""
        return max(1, self.objects - self.empty)

    @property
    def right_share(self) -> float:
        """Per cent of the objects that are in the right bin."""
        return 100.0 * self.right / self.objects_seen

    @property
    def purity(self) -> float:
        """Per cent of the decided objects that are in the right bin."""
        return 100.0 * self.right / max(1, self.right + self.wrong)


def read(file: Path) -> list[Row]:
    """Return the rows of a file; none if it does not exist."""
    if not file.exists():
        return []
    with file.open(newline="") as lines:
        return [Row.of(line) for line in csv.DictReader(lines)]


def mean_and_error(values: Sequence[float]) -> str:
    """Return mean and standard error as text."""
    array = np.array(values)
    error = array.std(ddof=1) / math.sqrt(len(array)) if len(array) > 1 else math.nan
    return f"{array.mean():6.1f} +-{error:4.1f}"


def table(every: Sequence[Row], planner_name: str) -> Iterator[str]:
    """Yield the lines of the table, with differences from a policy."""
    groups: dict[tuple[float, str], dict[int, Row]] = defaultdict(dict)
    for row in every:
        groups[row.speed, row.policy][row.belt] = row
    yield "m/s    policy                      belts  right %        purity %       missed %       /min  looks"
    for (speed, name), belts in sorted(groups.items()):
        each = list(belts.values())
        planner = groups.get((speed, planner_name), {})
        paired = [row.right_share - planner[n].right_share for n, row in belts.items() if n in planner]
        missed = [100.0 * row.missed / row.objects_seen for row in each]
        columns = ([row.right_share for row in each], [row.purity for row in each], missed)
        rate = np.mean([60.0 * row.objects / row.seconds for row in each])
        looks = np.mean([row.looks / row.objects for row in each])
        numbers = "  ".join(mean_and_error(column) for column in columns)
        behind = f"  right - planner {mean_and_error(paired)}" if paired else ""
        yield f"{speed:5.3f}  {name:27} {len(each):4}  {numbers}  {rate:5.1f}  {looks:4.2f}{behind}"
    times = [row for row in every if row.plan_p99 > 0.0]
    if times:
        worst = max(row.plan_p99 / row.tick for row in times)
        yield f"the 99th percentile of a plan's time was at most {worst:.3f} of a tick on any belt"
