"""Reliability curves as a picture."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from beltsort.calibration.reliability import Reliability
from beltsort.util.calibration_error import EDGES
from beltsort.util.extras import extra

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS, CHANCE = "#0072B2", "0.85"  # Okabe & Ito's blue on light grey: distinct in grey as well
INCHES = 4.0  # of one panel
FEWEST = 10  # pairs in a bin that is drawn: the share of fewer says nothing


def draw_reliability(arms: Mapping[str, Mapping[str, Reliability]], path: Path) -> None:
    """Draw a row of panels for each arm, a panel for each kind of pairs.

    Points are the bins with at least `FEWEST` pairs, their number above the axis, with the 95 % bootstrap
    band of objects; the grey band holds 95 % of the points if beliefs are calibrated.

    Parameters
    ----------
    arms
        Curves by arm and kind, the same kinds for all arms.
    path
        The picture; its ending (png, svg, pdf) is its format.
    """
    with extra("plot"):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

    kinds = list(next(iter(arms.values())))
    figure = Figure(figsize=(INCHES * len(kinds), INCHES * len(arms) + 0.4), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(arms), len(kinds), squeeze=False)
    for row, (name, curves) in zip(panels, arms.items(), strict=True):
        for panel, kind in zip(row, kinds, strict=True):
            _draw_panel(panel, curves[kind])
            panel.set_title(f"{name}: {kind}\n{_summary(curves[kind])}", parse_math=False, fontsize=10)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(path, dpi=120)


def _summary(curve: Reliability) -> str:
    return f"ECE {curve.ece:.3f} ± {curve.ece_error:.3f}, by chance {curve.ece_chance:.3f}"


def _draw_panel(panel: "Axes", curve: Reliability) -> None:
    drawn = curve.counts >= FEWEST
    if not drawn.any():
        drawn = curve.counts > 0
    belief, share = curve.belief[drawn], curve.share[drawn]
    bars = np.abs(curve.band[:, drawn] - share)
    panel.plot([0.0, 1.0], [0.0, 1.0], color="black", linewidth=0.8, label="calibrated")
    panel.fill_between(belief, *curve.chance[:, drawn], color=CHANCE, label="95 % by chance, if calibrated")
    panel.errorbar(belief, share, bars, color=POINTS, marker="o", markersize=4, capsize=2, label="came true")
    left = EDGES[int(drawn.argmax())]
    bottom = min(left, float(curve.band[0, drawn].min()), float(curve.chance[0, drawn].min()))
    for x, n in zip(belief, curve.counts[drawn], strict=True):
        panel.annotate(
            str(n), (x, 0.01), xycoords=("data", "axes fraction"), fontsize=7, rotation=90, ha="center"
        )
    panel.set_xlim(left - 0.03 * (1.0 - left), 1.0 + 0.03 * (1.0 - left))
    panel.set_ylim(bottom - 0.15 * (1.0 - bottom), 1.0 + 0.03 * (1.0 - bottom))
    panel.set(xlabel="belief", ylabel="share that came true")
    panel.grid(alpha=0.3)
