"""The paper's Fig. 1 and 2: reachable viewpoints, point clouds of objects, the belief on the belt."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from beltsort import Belief, SortingModel
from beltsort.errors import MissingExtraError
from beltsort.geometry import Points
from beltsort.paper.design import Stream, seed_of
from beltsort.paper.style import new_figure
from beltsort.perception import segment
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sim.bulbs import bulb
from beltsort.util.colours import COLOURS
from beltsort.util.figure_style import COLUMN, column_style, empty_figure
from beltsort.util.text import position_number
from beltsort.viewpoints import Sampling, ViewpointMap, map_viewpoints
from beltsort.viewpoints.arm import Arm, load_pinocchio
from beltsort.viewpoints.robots import robot_urdf

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS, VIEWPOINTS = 100, 3
LOWEST = 20.0  # degrees; below, cups and belt are in the camera's way
ROBOT, BASE = "ur5", (-0.4, 0.0, 0.2, 0.0)  # metres and degrees; not the paper's robot or place

VIEWPOINT = 1
HALF_HEIGHT = 0.06  # metres; of each box about its cloud's centre

HATCHES = ("", "//", "..", "xx")
SCANS = ((2, (0, 1)), (2, (0, 1)))
"""(viewpoint, label at each position) of the scans drawn: an elongated bulb before a livarno."""


def reached_sphere() -> tuple[ViewpointMap, str]:
    """Return the map of viewpoints, and in words which points count as reachable.

    Without the extra `ik`, every point above `LOWEST` counts.
    """
    try:
        load_pinocchio()
        urdf, tip = robot_urdf(ROBOT)
    except MissingExtraError:
        arm = None
        reached = f"everything above {LOWEST:g} degrees; the extra `ik` would tell what an arm reaches"
    else:
        arm = Arm(urdf, tip, BASE)
        x, y, z, _yaw = BASE
        reached = f"what a {ROBOT.upper()} based at ({x:g}, {y:g}, {z:g}) m reaches above {LOWEST:g} degrees"
    views = map_viewpoints(Sampling(count=POINTS), VIEWPOINTS, lowest=LOWEST, reachable=arm)
    return views, reached


@column_style()
def clouds_figure(config: CellConfig, seed: int) -> "Figure":
    """Draw the mesh of each class as points, and below it a candidate that was cut from a scan."""
    models = [bulb(name).vertices for name in config.classes]
    rows = (("model", models), ("candidate", candidates(config, seed)))
    figure = empty_figure(COLUMN, 2.2)
    limits = (-HALF_HEIGHT, HALF_HEIGHT)
    for line, (kind, clouds) in enumerate(rows):
        for i, (name, points) in enumerate(zip(config.classes, clouds, strict=True)):
            panel = figure.add_subplot(len(rows), len(models), line * len(models) + i + 1, projection="3d")
            centred = points - (points.min(axis=0) + points.max(axis=0)) / 2.0 if len(points) else points
            panel.scatter(*centred.T, s=0.3, color=COLOURS[i], depthshade=False, rasterized=True)
            panel.set(xlim=limits, ylim=limits, zlim=limits, xticks=(), yticks=(), zticks=())
            panel.set_title(f"{kind}:\n{name}\n{len(points)} points", pad=0.0)
            panel.set_box_aspect((1.0, 1.0, 1.0))
            panel.view_init(20.0, 35.0)
    return figure


def candidates(config: CellConfig, seed: int, attempts: int = 20) -> list[Points]:
    """Return a candidate of each class at the belt end, shape (n, 3), world frame, metres.

    Up to `attempts` objects of a class are scanned until one gives a candidate; n = 0 if none does.
    """
    found = [np.zeros((0, 3)) for _ in config.classes]
    for label in range(len(config.classes)):
        for attempt in range(attempts):
            cell = SimulatedCell([label], config, seed=seed_of(seed, Stream.RUN, label, attempt))
            scan = cell.scan(not_before=cell.move_to(VIEWPOINT, "move"))
            points = segment(scan, config.layout).objects[0]
            if points is not None:
                found[label] = points
                break
    return found


def propagated(
    model: SortingModel, scans: Sequence[tuple[int, Sequence[int]]] = SCANS
) -> list[tuple[str, NDArray[np.float64]]]:
    """Return the belief at the start, after each scan, and after a decision, with which the belt advances.

    Returns
    -------
    list of (str, array)
        A name, and probabilities of shape (H, L).

    Examples
    --------
    >>> from beltsort.models import paper
    >>> stages = propagated(paper())
    >>> bool(np.array_equal(stages[-1][1][0], stages[-2][1][1]))
    True
    """
    belief = Belief(model)
    stages = [("arrival prior", belief.probabilities)]
    for viewpoint, labels in scans:
        belief.observe(viewpoint, labels)
        said = ", ".join(model.labels[label] for label in labels)
        stages.append((f"scan from {model.viewpoints[viewpoint]}:\n{said}", belief.probabilities))
    label, _ = belief.most_likely(0)
    belief.advance()
    return [*stages, (f"decide {model.classes[label]},\nbelt moves on", belief.probabilities)]


@column_style()
def propagation_figure(model: SortingModel) -> "Figure":
    """Draw the belief of each position, a row per stage; the belt moves from right to left."""
    stages = propagated(model)
    figure, panels = new_figure(len(stages), model.positions, 0.75, sharex=True, sharey=True)
    for line, (name, probabilities) in zip(panels, stages, strict=True):
        line[0].set_title(name.replace("\n", " "), loc="left")
        for j, panel in enumerate(line):
            bars = panel.barh(model.classes, probabilities[j], edgecolor="black", linewidth=0.5)
            for i, bar in enumerate(bars):
                bar.set(facecolor=COLOURS[i % len(COLOURS)], hatch=HATCHES[i % len(HATCHES)])
                p = probabilities[j, i]
                panel.text(p + 0.02, i, f"{p:.2f}", ha="left", va="center")
            panel.set(xlim=(0.0, 1.2), xticks=(0.0, 0.5, 1.0))
    panels[0, 0].invert_yaxis()  # the first class on top; the axis is shared
    for j, panel in enumerate(panels[-1]):
        panel.set_xlabel(f"belief, position {position_number(j)}")
    return figure
