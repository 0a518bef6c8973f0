"""Measurement of perception speed, compared with a plain pipeline."""

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from beltsort._core import BUILD_PROFILE
from beltsort.cell.protocols import Scan
from beltsort.geometry import Points
from beltsort.perception import PerceptionConfig, vfh
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.util.machine import processor_name, processors
from benchmarks.machine.plain_vfh import plain_vfh
from benchmarks.machine.planning import checked_seconds, repeated
from benchmarks.machine.stages import own_stages, plain_stages
from benchmarks.machine.stopwatch import Stopwatch

TRUE_LABELS = (3, 0, 1)
DESCRIPTOR_POINTS = 2000
UNSHARED = "deproject"  # a scan already holds points; counted for neither side


@dataclass(frozen=True)
class Stage:
    """Seconds per scan, medians; None where a pipeline has no such stage.

    Attributes
    ----------
    name
        What is done.
    own, plain
        By beltsort, and by the plain pipeline.
    """

    name: str
    own: float | None
    plain: float | None


@dataclass(frozen=True)
class PerceptionBench:
    """What was measured, and on what.

    Attributes
    ----------
    processor, processors, build_profile
        As in `benchmarks.machine.planning.Bench`.
    scans
        Different scans of the simulated cell, each perceived in every turn.
    turns
        How often.
    stages
        In order, those of the plain pipeline alone first.
    own, plain
        Seconds per scan in all but deprojection, medians.
    ratio
        Of `plain` to `own`, the median of each turn's.
    descriptor_points
        Size of the cloud of which one descriptor was timed alone.
    descriptor, plain_descriptor
        Seconds for it, compiled and in NumPy, medians.
    descriptor_ratio
        Of the second to the first, the median of each turn's.
    """

    processor: str
    processors: int
    build_profile: str
    scans: int
    turns: int
    stages: tuple[Stage, ...]
    own: float
    plain: float
    ratio: float
    descriptor_points: int
    descriptor: float
    plain_descriptor: float
    descriptor_ratio: float


def run_bench_perception(seconds: float) -> PerceptionBench:
    """Perceive the same scans of the simulated cell with both pipelines, in turns.

    Parameters
    ----------
    seconds
        Time to spend, about; three turns are made however short it is.

    Raises
    ------
    ArgumentError
        If `seconds` is not a finite time above 0.
    """
    checked_seconds(seconds)
    cell = CellConfig()
    scans = [_scan(cell, viewpoint) for viewpoint in range(len(cell.viewpoints))]
    _turn(cell, scans)  # loads libraries, fills caches
    turns = repeated(lambda: _turn(cell, scans), 0.9 * seconds)
    own, plain = (
        {name: float(np.median([turn[side][name] for turn in turns])) for name in turns[0][side]}
        for side in (0, 1)
    )
    totals = np.array([[_total(own), _total(plain)] for own, plain in turns])  # (turns, 2)
    descriptors = np.array(repeated(_descriptor_turn, 0.1 * seconds))  # (turns, 2)
    (own_total, plain_total), (descriptor, plain_descriptor) = (
        np.median(of_turns, axis=0).tolist() for of_turns in (totals, descriptors)
    )
    names = dict.fromkeys([UNSHARED, *own, *plain])
    return PerceptionBench(
        processor=processor_name(),
        processors=processors(),
        build_profile=BUILD_PROFILE,
        scans=len(scans),
        turns=len(turns),
        stages=tuple(Stage(name, own.get(name), plain.get(name)) for name in names),
        own=own_total,
        plain=plain_total,
        ratio=float(np.median(totals[:, 1] / totals[:, 0])),
        descriptor_points=DESCRIPTOR_POINTS,
        descriptor=descriptor,
        plain_descriptor=plain_descriptor,
        descriptor_ratio=float(np.median(descriptors[:, 1] / descriptors[:, 0])),
    )


def _scan(config: CellConfig, viewpoint: int) -> Scan:
    cell = SimulatedCell(TRUE_LABELS, config, seed=1)
    return cell.scan(not_before=cell.move_to(viewpoint, "move"))


def _turn(cell: CellConfig, scans: list[Scan]) -> tuple[dict[str, float], dict[str, float]]:
    """Return the seconds per scan of each stage of both pipelines."""
    own, plain = Stopwatch(), Stopwatch()
    config = PerceptionConfig()
    for scan in scans:
        own_stages(scan, cell, config, own)
        plain_stages(scan, cell, config, plain)
    return _per_scan(own, len(scans)), _per_scan(plain, len(scans))


def _per_scan(watch: Stopwatch, scans: int) -> dict[str, float]:
    return {name: seconds / scans for name, seconds in watch.seconds.items()}


def _total(stages: dict[str, float]) -> float:
    return sum(seconds for name, seconds in stages.items() if name != UNSHARED)


def _descriptor_turn() -> tuple[float, float]:
    """Return the seconds of one descriptor, compiled and in NumPy."""
    points, normals = _ellipsoid()
    eye = np.array([0.0, 0.0, 1.0])
    began = perf_counter()
    vfh(points, normals, viewpoint=eye)
    between = perf_counter()
    plain_vfh(points, normals, eye)
    return between - began, perf_counter() - between


def _ellipsoid() -> tuple[Points, Points]:
    normals = np.random.default_rng(0).normal(size=(DESCRIPTOR_POINTS, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals * (0.03, 0.03, 0.06), normals
