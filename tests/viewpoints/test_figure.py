"""The picture names what it shows."""

import re
from pathlib import Path

import pytest

from beltsort.viewpoints import Sampling, map_viewpoints
from beltsort.viewpoints.figure import draw_sphere


@pytest.mark.parametrize(("viewpoints", "lowest"), [(1, 0.0), (5, 30.0), (40, 0.0)])
def test_viewpoints_units_and_kinds_of_points_are_named(
    tmp_path: Path, viewpoints: int, lowest: float
) -> None:
    views = map_viewpoints(Sampling(count=60), viewpoints, lowest=lowest)
    draw_sphere(views, tmp_path / "sphere.svg")
    texts = re.findall(r"<!-- *(.*?) *-->", (tmp_path / "sphere.svg").read_text())
    for name in views.names:
        assert texts.count(name) == 2  # one in each panel
    assert {"x, upstream (m)", "y (m)", "z (m)", "30°", "reachable", "unreachable", "viewpoint"} <= set(texts)
