from dataclasses import replace

import numpy as np
import pytest

from beltsort.geometry import Points
from beltsort.sim import CellConfig, PoseMix
from beltsort.sim.bulbs import CLASSES, bulb
from beltsort.sim.objects import at_rest, draw_object
from beltsort.sim.surfaces import Mesh

CONFIG = CellConfig()


def depth_inside_cup(vertices: Points) -> Points:
    """Return how far each vertex lies inside the solid of cup and belt, metres, negative outside."""
    cup, layout = CONFIG.cup, CONFIG.layout
    rho = np.hypot(vertices[:, 0], vertices[:, 1])
    slope = (layout.rim_height - cup.floor_height) / (layout.rim_radius - cup.wall - cup.floor_radius)
    wall = np.clip(cup.floor_height + slope * (rho - cup.floor_radius), cup.floor_height, layout.rim_height)
    return np.where(rho <= layout.rim_radius, wall, 0.0) - vertices[:, 2]


@pytest.mark.parametrize("name", CLASSES)
def test_objects_touch_the_cup_and_never_pierce_it(name: str) -> None:
    for seed in range(5):
        mesh = draw_object(bulb(name), CONFIG, np.random.default_rng(seed))
        assert depth_inside_cup(mesh.vertices).max() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", CLASSES)
def test_an_upright_bulb_stands_on_the_floor_of_its_cup(name: str) -> None:
    resting = at_rest(bulb(name), CONFIG.cup, CONFIG.layout)
    assert resting.vertices[:, 2].min() == pytest.approx(CONFIG.cup.floor_height, abs=1e-3)


def test_a_ball_wider_than_the_rim_rests_on_it() -> None:
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(20_000, 3))
    radius = 0.06
    ball = Mesh(
        radius * directions / np.linalg.norm(directions, axis=1)[:, None], np.zeros((0, 3), dtype=int)
    )
    resting = at_rest(ball, CONFIG.cup, CONFIG.layout)
    inner = CONFIG.layout.rim_radius - CONFIG.cup.wall
    middle = (resting.vertices[:, 2].max() + resting.vertices[:, 2].min()) / 2.0
    assert middle == pytest.approx(CONFIG.layout.rim_height + np.sqrt(radius**2 - inner**2), abs=2e-3)


def test_size_spread_is_that_of_the_logarithm() -> None:
    upright = replace(CONFIG, poses=PoseMix(1.0, 0.0, 0.0, upright_tilt=(0.0, 0.0)), size_spread=0.1)
    nominal = Mesh(bulb("standard").vertices[::40], np.zeros((0, 3), dtype=int))
    lengths = [
        np.ptp(draw_object(nominal, upright, np.random.default_rng(seed)).vertices[:, 2])
        for seed in range(200)
    ]
    assert np.std(np.log(lengths)) == pytest.approx(0.1, rel=0.2)


def test_lying_objects_lie_and_upright_ones_stand() -> None:
    def slimness(poses: PoseMix) -> float:
        config = replace(CONFIG, poses=poses, size_spread=0.0)
        extent = np.ptp(draw_object(bulb("elongated"), config, np.random.default_rng(1)).vertices, axis=0)
        return float(extent[2] / np.hypot(extent[0], extent[1]))

    assert slimness(PoseMix(1.0, 0.0, 0.0)) > 1.5
    assert slimness(PoseMix(0.0, 0.0, 1.0)) < 0.7
