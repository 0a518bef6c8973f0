"""What scans of known objects showed of them, counted; and what a count like that points to."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import median
from typing import Any

from beltsort.errors import RecordingError
from beltsort.perception.finding import Finding
from beltsort.perception.pose_fault import PoseFault
from beltsort.tables.scans import LabelledScan
from beltsort.util.text import position_number, text_table

LABEL = "label"
NO_LABEL = "no label"
"""Stands for an object that the classifier rejects."""
NOT_KEPT = "not kept"
"""Stands for a finding of a log that keeps none."""

REMEDIES = {
    NO_LABEL: "train the classifier on such objects, or raise its rejection distance",
    Finding.EMPTY: "check the order of the positions, the classes listed, and whether x or y are mirrored",
    Finding.HIDDEN: "check crop, rim height and viewpoint: something is in the way, or gives no return",
    Finding.TOO_FEW: "scan from closer, or check the rim's height",
    Finding.SEVERAL: "check the crop's radius and what else stands in the cup",
    Finding.CUT: "move the viewpoint back: objects reach the edge of the image",
}
ORDER = (LABEL, NO_LABEL, *(finding for finding in Finding if finding is not Finding.OBJECT), NOT_KEPT)
FEWEST_LOOKS = 4  # at a position from a viewpoint, before a finding is called usual there


@dataclass(frozen=True)
class FindingCounts:
    """What was found in looks at objects of known class, and the faults of the scans' poses.

    Attributes
    ----------
    viewpoints
        Names of the viewpoints.
    scans
        Number of scans.
    counts
        Number of looks by position, viewpoint and what was found: `LABEL`, `NO_LABEL`, or a `Finding`.
    faults
        Number of scans by the likely fault of their pose; its height is the median of theirs.

    Examples
    --------
    >>> scans = [LabelledScan(0, (1, 0), ("a", "b"), (1, None), (Finding.OBJECT, Finding.EMPTY))]
    >>> found = FindingCounts.of(scans, ["above"])
    >>> found.looks, found.labelled
    (2, 1)
    >>> found.to_dict()["viewpoints"]
    {'above': {'label': 1, 'empty': 1}}
    """

    viewpoints: tuple[str, ...]
    scans: int
    counts: Counter[tuple[int, int, str]]
    faults: dict[PoseFault, int]

    @classmethod
    def of(cls, scans: Sequence[LabelledScan], viewpoints: Sequence[str]) -> "FindingCounts":
        """Count the findings of scans."""
        counts = Counter(
            (position, scan.viewpoint, _what(scan, position))
            for scan in scans
            for position, true in enumerate(scan.true)
            if true is not None
        )
        return cls(tuple(viewpoints), len(scans), counts, faults_of(scan.pose_fault for scan in scans))

    @property
    def looks(self) -> int:
        """Number of looks at objects."""
        return self.counts.total()

    @property
    def labelled(self) -> int:
        """Number of looks that got a label."""
        return sum(n for (_, _, what), n in self.counts.items() if what == LABEL)

    def check_labelled(self) -> None:
        """Raise a `RecordingError` if no look at an object got a label."""
        if self.labelled == 0:
            found = ", ".join(f"{n} {what}" for what, n in self._totals().items()) or "no class is known"
            raise RecordingError(
                f"none of {self.looks} looks at objects got a label ({found}), expected some, to estimate "
                f"tables from: {next(self.warnings(), 'check the poses and the classes of the scans')}"
            )

    def warnings(self) -> Iterator[str]:
        """Yield a sentence for each kind of fault, and each finding that is usual instead of a label."""
        yield from fault_texts(self.faults, self.scans)
        looks: Counter[tuple[int, int]] = Counter()
        for (position, viewpoint, _), n in self.counts.items():
            looks[position, viewpoint] += n
        for what, remedy in REMEDIES.items():
            usual = {
                where: self.counts[*where, what]
                for where, all_looks in sorted(looks.items())
                if all_looks >= FEWEST_LOOKS and 2 * self.counts[*where, what] > all_looks
            }
            if usual:
                places = ", ".join(
                    f"position {position_number(j)} from {self.viewpoints[k]}" for j, k in usual
                )
                total = sum(looks[where] for where in usual)
                yield f"{sum(usual.values())} of {total} looks at objects found '{what}' ({places}): {remedy}"

    def to_dict(self) -> dict[str, Any]:
        """Return the counts as plain data."""
        return {
            "viewpoints": {
                name: {str(what): n for what, n in self._totals(k).items() if n}
                for k, name in enumerate(self.viewpoints)
            },
            "pose_faults": [{"likely": str(fault), "scans": n} for fault, n in self.faults.items()],
            "warnings": list(self.warnings()),
        }

    def __str__(self) -> str:
        """Return a table with a row for each viewpoint."""
        rows = [
            [name, *map(str, self._totals(viewpoint).values())]
            for viewpoint, name in enumerate(self.viewpoints)
        ]
        return text_table([["viewpoint", *self._totals()], *rows])

    def _totals(self, viewpoint: int | None = None) -> Counter[str]:
        """Return the number of looks by what was found, all that occur anywhere, in order."""
        found: Counter[str] = Counter(
            {what: 0 for what in ORDER if any(what == w for _, _, w in self.counts)}
        )
        for (_, k, what), n in self.counts.items():
            found[what] += n if viewpoint in (None, k) else 0
        return found


def faults_of(faults: Iterable[PoseFault | None]) -> dict[PoseFault, int]:
    """Count the faults of scans by cause, the most frequent first; the height is the median one."""
    heights: dict[PoseFault, list[float]] = {}
    for fault in faults:
        if fault is not None:
            heights.setdefault(replace(fault, height=None), []).append(fault.height or 0.0)
    counted = sorted(heights.items(), key=lambda item: -len(item[1]))
    return {replace(kind, height=median(each) or None): len(each) for kind, each in counted}


def fault_texts(faults: dict[PoseFault, int], scans: int) -> Iterator[str]:
    """Yield a sentence for each fault of the poses of some of so many scans."""
    for fault, n in faults.items():
        yield f"{n} of {scans} scans do not show the belt where their pose says; likely: {fault}"


def _what(scan: LabelledScan, position: int) -> str:
    """Return what a look found."""
    finding = scan.findings[position] if scan.findings else None
    if finding not in (None, Finding.OBJECT):
        return str(finding)
    if scan.observed[position] is not None:
        return LABEL
    return NOT_KEPT if finding is None else NO_LABEL
