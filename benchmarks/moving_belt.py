"""`python -m benchmarks.moving_belt`: tracks and labels from depth scans of a belt that does not stop.

Each belt carries the same objects in every circumstance, so that circumstances differ in nothing else. The
camera stands at one viewpoint and takes a scan each time the belt has moved on by half a pitch; at speed 0
the belt stops for each scan. The classifier is that of the simulated cell, trained on belts that stand.

The counts of each belt are kept in a CSV file (`--file`). What it contains is not measured again, and a call
with other belts (`--first 10`) adds to it. At the end the whole file is printed as a table: means and
standard errors over belts.
"""

import argparse
import csv
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beltsort.cell import Scan
from beltsort.perception import Finding, Perception
from beltsort.sim import BeltDrive, CellConfig, MovingCell
from beltsort.sim.prepare import prepare
from beltsort.tracking import (
    Ambiguous,
    BeltMotion,
    Lost,
    MotionConfig,
    TrackedScan,
    Tracker,
    TrackerConfig,
    track_scan,
)

VIEWPOINT = 2  # p3, which sees the belt from above
READINGS = 0.02  # seconds between readings of the encoder
JITTER = 0.008  # metres, of the cups' places
EMPTY = 0.1  # share of empty cups
COUNTED = (-0.04, 0.22)  # metres along the belt; the classifier was trained at 0 and 0.18
COUNTS = "objects untracked retracked confused phantom lost ambiguous"
NEAR = 0.04  # metres; what is seen so near to an object is the object
STANDING = 0.1  # m/s, between scans of the belt that stops
MEASURES = (
    "due", "found", "labelled", "right", "objects", "untracked", "retracked", "confused", "phantom", "lost",
    "ambiguous", "places", "square_mm",
)  # fmt: skip


@dataclass(frozen=True)
class Circumstance:
    """Speed (m/s) and exposure (s), an encoder's errors, and whether the smear is corrected."""

    speed: float
    exposure: float
    scale: float = 1.0
    jitter: float = 0.0
    corrected: bool = True

    def __str__(self) -> str:
        encoder = f"scale {self.scale:g}, jitter {1000 * self.jitter:g} mm"
        smear = "corrected" if self.corrected else "left"
        return f"{self.speed:4.2f} m/s  {1000 * self.exposure:3.0f} ms  {encoder:24}  smear {smear:9}"


STOPPING = Circumstance(0.0, 0.01)


def circumstances() -> Iterator[Circumstance]:
    """Yield what is measured, in order."""
    yield STOPPING
    for exposure in (0.01, 0.1):
        for speed in (0.05, 0.1, 0.2, 0.5):
            yield Circumstance(speed, exposure)
    for speed in (0.2, 0.5):
        yield Circumstance(speed, 0.1, corrected=False)
    for scale, jitter in ((1.01, 0.0), (1.0, 0.002), (1.01, 0.002)):
        yield Circumstance(0.2, 0.01, scale, jitter)


@dataclass(eq=False)
class Belt:
    """One belt of `objects` cups, the number of which is also its seed."""

    circumstance: Circumstance
    number: int
    objects: int
    counts: Counter[str] = field(default_factory=Counter)
    object_of: dict[int, int] = field(default_factory=dict)  # by track, what it was opened for
    tracks_of: dict[int, set[int]] = field(default_factory=lambda: defaultdict(set))  # by object that was due

    def run(self, perception: Perception) -> Counter[str]:
        """Return the counts, by the names of `MEASURES`."""
        here, config = self.circumstance, CellConfig()
        drawn = np.random.default_rng(self.number).integers(len(config.classes), size=self.objects)
        moving = BeltDrive(
            here.speed or STANDING, JITTER, EMPTY, here.exposure,
            encoder_scale=here.scale, encoder_jitter=here.jitter,
        )  # fmt: skip
        cell = MovingCell(drawn.tolist(), moving, config, self.number)
        cell.stop()
        cell.move_to(VIEWPOINT, "move")
        cell.set_speed(here.speed or STANDING)
        motion = BeltMotion(MotionConfig(reading_error=max(here.jitter, 0.0005)))
        tracker = Tracker(motion, TrackerConfig(scale_error=max(abs(here.scale - 1.0), 0.005)))
        motion.add(cell.encoder())
        while cell.travel(cell.clock) < (self.objects + 1) * config.layout.spacing:
            scan = self._next_scan(cell, motion)
            stamp = scan.stamp + here.exposure / 2.0
            dated = scan if here.corrected else replace(scan, stamp=stamp)
            exposure = here.exposure if here.corrected else 0.0
            self._count(track_scan(dated, tracker, perception, exposure=exposure), tracker, cell, stamp)
        self.counts["objects"] = len(self.tracks_of)
        self.counts["untracked"] = sum(not tracks for tracks in self.tracks_of.values())
        self.counts["retracked"] = sum(len(tracks) > 1 for tracks in self.tracks_of.values())
        return self.counts

    def _next_scan(self, cell: MovingCell, motion: BeltMotion) -> Scan:
        """Let the belt move on by half a pitch and return a scan; the encoder is read all the while."""
        half, speed = cell.layout.spacing / 2.0, self.circumstance.speed
        during = max(cell.config.scan_seconds, self.circumstance.exposure) if speed > 0.0 else 0.0
        until = cell.clock + half / (speed or STANDING) - during
        while cell.clock < until:
            cell.wait(min(READINGS, until - cell.clock))
            motion.add(cell.encoder())
        if speed == 0.0:
            cell.set_speed(0.0)
        scan = cell.scan(not_before=cell.clock)
        motion.add(cell.encoder())
        if speed == 0.0:
            cell.set_speed(STANDING)
        return scan

    def _count(self, seen: TrackedScan, tracker: Tracker, cell: MovingCell, stamp: float) -> None:
        """Compare what a scan has shown with what was there."""
        numbers = range(self.objects)
        truth = {n: cell.place(n, stamp) for n in numbers if cell.true_class(n) is not None}
        for number, x in truth.items():
            if not COUNTED[0] < x < COUNTED[1]:
                continue
            self.counts["due"] += 1
            looks = [look for look in seen.looks if abs(look.place - x) < NEAR]
            tracks = {look.track for look in looks} - {None}
            self.tracks_of[number] |= {track for track in tracks if track is not None}
            found = [look.perceived for look in looks if look.perceived.finding is Finding.OBJECT]
            self.counts["found"] += bool(found)
            self.counts["labelled"] += any(look.label is not None for look in found)
            self.counts["right"] += any(look.label == cell.true_class(number) for look in found)
        for look in seen.looks:
            if look.track is not None:
                near = [number for number, x in truth.items() if abs(look.place - x) < NEAR]
                self.counts["phantom"] += not near
                if near:
                    self.counts["confused"] += self.object_of.setdefault(look.track, near[0]) != near[0]
        self.counts["lost"] += sum(isinstance(event, Lost) for event in seen.update.events)
        self.counts["ambiguous"] += sum(isinstance(event, Ambiguous) for event in seen.update.events)
        for expected in tracker.expected(stamp):
            if expected.track in self.object_of:
                error = expected.place - cell.place(self.object_of[expected.track], stamp)
                self.counts["places"] += 1
                self.counts["square_mm"] += round((1000.0 * error) ** 2)


Rows = dict[Circumstance, dict[int, Counter[str]]]


def read(file: Path) -> Rows:
    """Return the counts by circumstance and belt."""
    rows: Rows = defaultdict(dict)
    if file.exists():
        with file.open(newline="", encoding="utf-8") as stored:
            for row in csv.DictReader(stored):
                speed, exposure, scale, jitter = (float(value) for value in list(row.values())[:4])
                here = Circumstance(speed, exposure, scale, jitter, row["corrected"] == "True")
                rows[here][int(row["belt"])] = Counter({name: int(row[name]) for name in MEASURES})
    return rows


def append(file: Path, belt: Belt) -> None:
    """Add the counts of a belt."""
    here, begun = belt.circumstance, file.exists()
    with file.open("a", newline="", encoding="utf-8") as stored:
        writer = csv.writer(stored, lineterminator="\n")
        if not begun:
            writer.writerow(["speed", "exposure", "scale", "jitter", "corrected", "belt", *MEASURES])
        of = [here.speed, here.exposure, here.scale, here.jitter, here.corrected, belt.number]
        writer.writerow([*of, *(belt.counts[name] for name in MEASURES)])


def mean(values: NDArray[np.float64]) -> str:
    """Return mean and standard error of shares, in per cent."""
    error = values.std(ddof=1) / len(values) ** 0.5 if len(values) > 1 else np.nan
    return f"{100.0 * values.mean():6.1f} ± {100.0 * error:.1f}"


def lines(rows: Rows) -> Iterator[str]:
    """Yield the table."""
    columns = f"{'right, of labelled':>18}  {'less than at stops':>18}  {'found, of due':>16}  place"
    yield f"{'':61}{columns}  {COUNTS}"

    def share(belts: dict[int, Counter[str]], part: str, whole: str) -> NDArray[np.float64]:
        return np.array([belts[n][part] / max(1, belts[n][whole]) for n in sorted(belts)])

    for here, belts in rows.items():
        total = sum(belts.values(), Counter[str]())
        paired = {n: rows[STOPPING][n] for n in belts if n in rows[STOPPING]}
        less = share(paired, "right", "labelled") - share({n: belts[n] for n in paired}, "right", "labelled")
        rms = (total["square_mm"] / max(1, total["places"])) ** 0.5
        counted = " ".join(str(total[name]) for name in COUNTS.split())
        yield (
            f"{here!s}  {mean(share(belts, 'right', 'labelled')):>14} %  {mean(less):>14} %  "
            f"{mean(share(belts, 'found', 'due')):>14} %  {rms:2.0f} mm  {counted}"
        )


def main() -> None:
    """Measure what the file does not contain, and print it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--belts", type=int, default=10)
    parser.add_argument("--first", type=int, default=0, help="number of the first belt")
    parser.add_argument("--objects", type=int, default=8, help="cups on each belt")
    parser.add_argument("--file", type=Path, default=Path("moving_belt.csv"))
    given = parser.parse_args()
    perception = Perception(CellConfig().layout, prepare().database)
    for number in range(given.first, given.first + given.belts):
        for here in circumstances():
            if number not in read(given.file)[here]:
                belt = Belt(here, number, given.objects)
                belt.run(perception)
                append(given.file, belt)
    print(*lines(read(given.file)), sep="\n")


if __name__ == "__main__":
    main()
