"""Example models and what a scan shows of such objects, as point clouds: part of the paper's Fig. 1."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from beltsort.geometry import Points
from beltsort.paper.design import Stream, seed_of
from beltsort.perception import segment
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sim.bulbs import bulb
from beltsort.util.colours import COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VIEWPOINT = 1
HALF_HEIGHT = 0.06  # metres; of each box about its cloud's centre


def candidates(config: CellConfig, seed: int, attempts: int = 20) -> list[Points]:
    """Return a candidate of each class at the belt end, world frame, metres, from a scan that shows it well.

    Of `attempts` objects of a class the first with a candidate counts; an empty cloud if there is none.
    """
    return [
        next(found, np.zeros((0, 3)))
        for label in range(len(config.classes))
        for found in [_candidates_of(config, label, seed, attempts)]
    ]


def _candidates_of(config: CellConfig, label: int, seed: int, attempts: int) -> Iterator[Points]:
    for attempt in range(attempts):
        cell = SimulatedCell([label], config, seed=seed_of(seed, Stream.RUN, label, attempt))
        scan = cell.scan(not_before=cell.move_to(VIEWPOINT, "move"))
        points = segment(scan, config.layout).objects[0]
        if points is not None:
            yield points


def clouds_figure(config: CellConfig, seed: int) -> "Figure":
    """Draw the mesh of each class as points, and below it a candidate that was cut from a scan."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    models = [bulb(name).vertices for name in config.classes]
    rows = (("model", models), ("candidate", candidates(config, seed)))
    figure = Figure(figsize=(2.4 * len(models), 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    for line, (kind, clouds) in enumerate(rows):
        for i, (name, points) in enumerate(zip(config.classes, clouds, strict=True)):
            panel = figure.add_subplot(len(rows), len(models), line * len(models) + i + 1, projection="3d")
            _cloud(panel, points, COLOURS[i], f"{kind}: {name}\n{len(points)} points")
    figure.suptitle("Models, and candidates cut from simulated scans; the boxes measure 12 cm", fontsize=10)
    return figure


def _cloud(panel: Any, points: Points, colour: str, title: str) -> None:
    centred = points - (points.min(axis=0) + points.max(axis=0)) / 2.0 if len(points) else points
    panel.scatter(*centred.T, s=1.5, color=colour, depthshade=False, rasterized=True)
    limits = (-HALF_HEIGHT, HALF_HEIGHT)
    panel.set(xlim=limits, ylim=limits, zlim=limits, xticks=(), yticks=(), zticks=())
    panel.set_title(title, fontsize=9)
    panel.set_box_aspect((1.0, 1.0, 1.0))
    panel.view_init(20.0, 35.0)
