"""How the viewer arranges a recording: the cell in space beside beliefs, values and the log."""

from types import ModuleType
from typing import Any

from beltsort.util.text import position_number

EYE, TARGET = (-0.75, -0.95, 0.75), (0.1, 0.0, 0.2)
"""Where the cell is looked at from, and where to, in the belt frame, metres."""


def arranged(rerun: ModuleType, positions: int) -> Any:
    """Return the arrangement (a rerun blueprint) for a cell with so many positions."""
    views = rerun.blueprint
    beliefs = [
        views.TimeSeriesView(
            origin=f"belief/position_{position_number(j)}",
            name=f"belief, position {position_number(j)}",
            axis_y=views.ScalarAxis(range=(-0.02, 1.02)),
        )
        for j in range(positions)
    ]
    return views.Blueprint(
        views.Horizontal(
            views.Vertical(
                views.Spatial3DView(
                    origin="world",
                    name="cell",
                    eye_controls=views.EyeControls3D(position=EYE, look_target=TARGET),
                ),
                views.TextLogView(origin="log", name="log"),
                row_shares=[3, 1],
            ),
            views.Vertical(*beliefs, views.TimeSeriesView(origin="plan", name="values of actions")),
        ),
        views.TimePanel(timeline="step", state="collapsed"),
        collapse_panels=True,
    )
