"""`python -m benchmarks.animation FILE.webp`: an animation of a run of the simulated cell, for README.

Clouds, labels, beliefs and decisions are those of the run, which is planned with the dependence of repeated
looks (`repeat`). Between scans the camera moves on its half-sphere, and the points of a decided object are
moved to their bin.
"""

from argparse import ArgumentParser
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

import beltsort
from beltsort.cell import Scan
from beltsort.geometry import Points, transform
from beltsort.perception import Perceived, Perception, segment
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sim.demo import TRIALS, true_labels
from beltsort.sim.prepare import prepare
from beltsort.sorting.entries import Decided, Scanned
from beltsort.sorting.journal import read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.runs import sort_into
from beltsort.util.colours import COLOURS

SEED = 27  # a run in which the camera moves: at most one object in three needs a second viewpoint
SIZE = (8.0, 4.0)  # inches
DPI = 100
LOOKED_FROM = (-62.0, 24.0)  # azimuth and elevation of the drawing's eye, degrees
SHOWN = 3500  # points of a scan
MOVING, FLYING, ADVANCING = 5, 7, 4  # frames
SHORT, LONG, LAST = 70, 650, 2500  # milliseconds
BINS = (-0.29, -0.3, 0.145)  # middle of their row and their distance, metres
GREY = "#9aa3ad"
BACKGROUND = "#ffffff"
TEXT = "#222222"


@dataclass(frozen=True)
class State:
    """What a frame shows.

    Attributes
    ----------
    eye
        Position of the camera, shape (3,), metres.
    points
        The last scan without its candidates, shape (n, 3).
    candidates
        For each position the candidate's points, or None.
    belief
        Shape (H, L).
    flying
        Points of the object on its way to a bin, and its class.
    binned
        Number of objects in each bin.
    scanning
        Whether the camera has just taken a scan.
    labels
        What the scan says, by position.
    said
        Two lines: which object it is, and what happens.
    """

    eye: Points
    points: Points
    candidates: tuple[Points | None, ...]
    belief: NDArray[np.float64]
    flying: tuple[Points, int] | None = None
    binned: tuple[int, ...] = ()
    scanning: bool = False
    labels: tuple[str, ...] = ()
    said: tuple[str, str] = ("", "")


@dataclass
class Scans:
    """Perception that keeps every scan, thinned, with its candidates."""

    perception: Perception
    taken: list[tuple[Points, tuple[Points | None, ...], Points]] = field(default_factory=list)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the labels."""
        return self.perception.labels

    def __call__(self, scan: Scan) -> list[Perceived]:
        """Label a scan, and keep it."""
        found = segment(scan, self.perception.layout, self.perception.config)
        points = scan.points.reshape(-1, 3)
        world = transform(scan.world_from_camera, points[np.isfinite(points).all(axis=1)])
        near = world[(np.abs(world[:, 1]) < 0.14) & (world[:, 0] > -0.2) & (world[:, 0] < 0.48)]
        for candidate in found.candidates:
            if candidate is not None:
                low, high = candidate.min(axis=0) - 0.004, candidate.max(axis=0) + 0.004
                near = near[~((near > low) & (near < high)).all(axis=1)]
        thinned = near[:: max(1, len(near) // SHOWN)]
        self.taken.append((thinned, tuple(found.candidates), scan.world_from_camera[:3, 3]))
        return self.perception(scan)


def states(seed: int, objects: int) -> Iterator[tuple[State, int]]:
    """Sort, and yield what each frame shows and for how long, milliseconds."""
    config, prepared = CellConfig(), prepare()
    names = [viewpoint.name for viewpoint in config.viewpoints]
    model = prepared.counts.model(config.classes, names, repeats=True)
    labels = true_labels(seed, config.classes)
    cell = SimulatedCell(labels, config, seed=seed)
    scans = Scans(Perception(config.layout, prepared.database))
    with TemporaryDirectory() as folder:
        planner = beltsort.Despot(model, seed=seed, trials=TRIALS)
        sort_into(Path(folder), cell, scans, planner, model, objects=objects)
        entries = read_journal(Path(folder) / JOURNAL)
    uniform = np.tile(model.arrival, (model.positions, 1))
    eye = config.viewpoints[0].pose()[:3, 3]
    state = State(eye, np.zeros((0, 3)), (None,) * model.positions, uniform, binned=(0,) * len(model.bins))
    taken = iter(scans.taken)
    number = 0
    for entry in entries:
        title = f"object {number + 1} of {objects}"
        match entry.content:
            case Scanned() as scanned:
                move = f"look from {model.viewpoints[scanned.viewpoint]}"
                state = replace(state, said=(title, move))
                yield from moved(state, config.viewpoints[scanned.viewpoint].pose()[:3, 3])
                points, candidates, eye = next(taken)
                seen = tuple("none" if label is None else model.labels[label] for label in scanned.labels)
                state = replace(
                    *(state,), eye=eye, points=points, candidates=candidates, scanning=True,
                    belief=np.array(scanned.belief), labels=seen,
                )  # fmt: skip
                yield state, LONG
                state = replace(state, scanning=False, labels=())
            case Decided(label=int(label), belief=sure):
                state = replace(state, said=(title, f"into {model.bins[label]}: belief {sure:.3f}"))
                yield state, LONG
                frames = list(sorted_into(state, label, config.layout.spacing, model))
                yield from frames
                state = frames[-1][0]
                number += 1
    right = sum(
        label == labels[n]
        for n, label in enumerate(e.content.label for e in entries if isinstance(e.content, Decided))
    )
    yield replace(state, said=(f"{objects} objects sorted", f"{right} right, {len(scans.taken)} looks")), LAST


def moved(state: State, to: Points) -> Iterator[tuple[State, int]]:
    """Move the camera on its half-sphere, over the top of the belt end."""
    if np.allclose(state.eye, to, atol=0.03):
        return
    for share in np.linspace(0.0, 1.0, MOVING + 1)[1:-1]:
        between = (1.0 - share) * state.eye + share * to
        radius = (1.0 - share) * np.linalg.norm(state.eye) + share * np.linalg.norm(to)
        yield replace(state, eye=between * (radius / np.linalg.norm(between))), SHORT


def sorted_into(
    state: State, label: int, spacing: float, model: beltsort.SortingModel
) -> Iterator[tuple[State, int]]:
    """Move the object at the belt end to its bin, then the belt by one position."""
    points, *others = state.candidates
    behind = replace(state, candidates=(None, *others))
    if points is not None:
        way = bin_place(label, len(model.bins)) - points.mean(axis=0)
        for share in np.linspace(0.0, 1.0, FLYING):
            lift = np.array([0.0, 0.0, 0.25 * np.sin(np.pi * share)])
            yield replace(behind, flying=(points + share * way + lift, label)), SHORT
    binned = tuple(n + (i == label) for i, n in enumerate(state.binned))
    handed_on = np.vstack([state.belief[1:], model.arrival])
    for share in np.linspace(0.0, 1.0, ADVANCING + 1)[1:]:
        shift = np.array([share * spacing, 0.0, 0.0])
        moving = tuple(None if each is None else each - shift for each in behind.candidates)
        yield replace(behind, points=state.points - shift, candidates=moving, binned=binned), SHORT
    arrived = tuple(None if each is None else each - shift for each in (*others, None))
    end = replace(behind, points=state.points - shift, candidates=arrived, binned=binned, belief=handed_on)
    yield end, 3 * SHORT


def bin_place(label: int, bins: int) -> Points:
    """Return where a bin stands, in front of the belt end."""
    x, y, spacing = BINS
    return np.array([x + (label - 0.5 * (bins - 1)) * spacing, y, 0.0])


def projected(points: Points) -> tuple[Points, NDArray[np.float64]]:
    """Return points on the drawing, shape (n, 2), and their nearness to its eye."""
    azimuth, elevation = np.radians(LOOKED_FROM)
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    towards = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    up = np.cross(towards, right)
    return np.column_stack([points @ right, points @ up]), points @ towards


class Drawing:
    """Draws frames."""

    def __init__(self, config: CellConfig) -> None:
        self.classes = config.classes
        self.viewpoints = config.viewpoints
        self.figure = Figure(figsize=SIZE, dpi=DPI, facecolor=BACKGROUND)
        FigureCanvasAgg(self.figure)
        self.scene = self.figure.add_axes((0.0, 0.0, 0.66, 1.0))
        self.bars = [self.figure.add_axes((0.76, bottom, 0.22, 0.27)) for bottom in (0.46, 0.06)]

    def frame(self, state: State) -> Image.Image:
        """Draw one frame."""
        self._scene(state)
        for position, axes in enumerate(self.bars):
            label = state.labels[position] if state.labels else ""
            self._beliefs(axes, position, state.belief[position], label)
        self.figure.texts.clear()
        self.figure.text(0.68, 0.93, state.said[0], fontsize=11, color=GREY, va="center")
        self.figure.text(0.68, 0.865, state.said[1], fontsize=11, color=TEXT, va="center", weight="bold")
        drawn = BytesIO()
        self.figure.savefig(drawn)
        return Image.open(drawn).convert("RGB")

    def _scene(self, state: State) -> None:
        axes = self.scene
        axes.clear()
        axes.set(xlim=(-0.74, 0.62), ylim=(-0.31, 0.76), aspect="equal")
        axes.axis("off")
        self._half_sphere(axes)
        self._bins(axes, state)
        place, near = projected(state.points)
        order = np.argsort(near)
        shade = 0.62 + 0.25 * (1.0 - np.clip(state.points[order, 2] / 0.06, 0.0, 1.0))
        axes.scatter(place[order, 0], place[order, 1], s=2.0, c=np.column_stack([shade] * 3), linewidths=0)
        for belief, candidate in zip(state.belief, state.candidates, strict=True):
            if candidate is not None:
                self._object(axes, candidate, int(belief.argmax()))
        if state.flying is not None:
            self._object(axes, *state.flying)
        self._camera(axes, state)

    def _object(self, axes: Axes, points: Points, label: int) -> None:
        place, _ = projected(points[:: max(1, len(points) // 400)])
        axes.scatter(place[:, 0], place[:, 1], s=4.0, color=COLOURS[label], linewidths=0)

    def _half_sphere(self, axes: Axes) -> None:
        turn = np.linspace(0.0, 2.0 * np.pi, 73)
        for elevation in (5.0, 25.0, 45.0, 70.0):
            height, radius = np.sin(np.radians(elevation)), np.cos(np.radians(elevation))
            ring = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(73, height)])
            ring *= self.viewpoints[0].radius
            axes.plot(*projected(ring)[0].T, color=GREY, linewidth=0.6, alpha=0.4)
        for viewpoint in self.viewpoints:
            (place,), _ = projected(viewpoint.pose()[None, :3, 3])
            axes.plot(*place, marker="o", markersize=5, color=GREY)
            axes.annotate(viewpoint.name, place, (-5, -6), textcoords="offset points", color=GREY, ha="right")

    def _camera(self, axes: Axes, state: State) -> None:
        (eye,), _ = projected(state.eye[None])
        if state.scanning:
            for corner in ((-0.09, -0.1, 0.0), (0.29, -0.1, 0.0), (0.29, 0.1, 0.0), (-0.09, 0.1, 0.0)):
                (foot,), _ = projected(np.array([corner]))
                axes.plot(*zip(eye, foot, strict=True), color="#E69F00", linewidth=0.9, alpha=0.8)
        axes.plot(*eye, marker="o", markersize=11, color="#E69F00" if state.scanning else TEXT)
        axes.plot(*eye, marker="o", markersize=4.5, color="white")
        axes.annotate("camera", eye, (9, 5), textcoords="offset points", fontsize=9, color=TEXT)

    def _bins(self, axes: Axes, state: State) -> None:
        for label, name in enumerate(self.classes):
            half = 0.05
            x, y, _ = bin_place(label, len(self.classes))
            around = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * half + (x, y)
            for height in (0.0, 0.07):
                ring, _ = projected(np.column_stack([around, np.full(5, height)]))
                axes.plot(*ring.T, color=COLOURS[label], linewidth=1.4)
            for corner in around[:4]:
                axes.plot(
                    *projected(np.array([(*corner, 0.0), (*corner, 0.07)]))[0].T, color=COLOURS[label], lw=1.4
                )
            (centre,), _ = projected(np.array([(x, y, 0.03)]))
            axes.text(
                centre[0],
                centre[1],
                f"{state.binned[label]}",
                ha="center",
                va="center",
                fontsize=12,
                color=TEXT,
                weight="bold",
            )
            (below,), _ = projected(np.array([(x, y - half, 0.0)]))
            axes.text(
                below[0], below[1] - 0.02, name, fontsize=9, color=COLOURS[label], ha="center", va="top"
            )

    def _beliefs(self, axes: Axes, position: int, belief: NDArray[np.float64], label: str) -> None:
        axes.clear()
        rows = np.arange(len(belief))[::-1]
        axes.barh(rows, np.ones(len(belief)), color="#eef0f2", height=0.72)
        axes.barh(rows, belief, color=COLOURS[: len(belief)], height=0.72)
        settings: dict[str, Any] = {"xlim": (0.0, 1.0), "xticks": (), "yticks": rows}
        axes.set(**settings)
        axes.set_yticklabels(self.classes, fontsize=9, color=TEXT)
        axes.tick_params(length=0)
        for side in axes.spines.values():
            side.set_visible(False)
        axes.set_title("belt end" if position == 0 else "next", fontsize=10, loc="left", pad=5)
        if label:
            colour = COLOURS[self.classes.index(label)] if label in self.classes else TEXT
            axes.set_title(f"seen as {label}", fontsize=10, color=colour, loc="right", pad=5)


def write(path: Path, seed: int, objects: int) -> None:
    """Draw a run and write it as an animated WebP or GIF, by the ending of `path`."""
    drawing = Drawing(CellConfig())
    frames, milliseconds = [], []
    for state, shown in states(seed, objects):
        frames.append(drawing.frame(state))
        milliseconds.append(shown)
    settings: dict[str, Any] = {"quality": 60, "method": 6} if path.suffix == ".webp" else {"optimize": True}
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=milliseconds, loop=0, **settings)


def main() -> None:
    """Run."""
    parser = ArgumentParser("benchmarks.animation", description=__doc__)
    parser.add_argument("file", type=Path, help="ends in .webp or .gif")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--objects", type=int, default=5)
    given = parser.parse_args()
    write(given.file, given.seed, given.objects)
    print(f"{given.file}: {given.file.stat().st_size} bytes")


if __name__ == "__main__":
    main()
