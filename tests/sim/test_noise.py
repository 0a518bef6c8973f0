from dataclasses import replace

import numpy as np
import pytest

from beltsort.sim import Camera, SensorNoise
from beltsort.sim.noise import View, noisy_depth, smooth_field

SHAPE = (100, 100)


def wall(depth: float = 0.7, *, incidence: float = 0.0, glass: bool = False, lit: bool = True) -> View:
    return View(
        top=0,
        left=0,
        depth=np.full(SHAPE, depth),
        incidence=np.full(SHAPE, incidence),
        mirror=np.full(SHAPE, 1.0),
        glass=np.full(SHAPE, glass),
        lit=np.full(SHAPE, lit),
    )


def measure(view: View, noise: SensorNoise, seed: int = 0) -> np.ndarray:
    return noisy_depth(view, noise, Camera(), np.random.default_rng(seed))


def test_axial_noise_is_nguyens() -> None:
    # sigma_z(z, theta) = 0.0012 + 0.0019 (z - 0.4)^2 + 0.0001 / sqrt(z) (theta / (pi/2 - theta))^2
    noise, quarter = SensorNoise(), np.array(np.pi / 4)
    assert noise.axial_sigma(np.array(0.4), np.array(0.0)) == pytest.approx(0.0012)
    assert noise.axial_sigma(np.array(1.4), np.array(0.0)) == pytest.approx(0.0012 + 0.0019)
    assert noise.axial_sigma(np.array(1.0), quarter) == pytest.approx(0.0012 + 0.0019 * 0.36 + 0.0001)
    assert noise.lateral_sigma(quarter) == pytest.approx(0.8 + 0.035)


def test_axial_noise_grows_with_distance_and_incidence(perfect_sensor: SensorNoise) -> None:
    axial = replace(perfect_sensor, axial_floor=0.0012, axial_growth=0.0019, axial_incidence=0.0001)

    def spread(depth: float, incidence: float) -> float:
        return float(measure(wall(depth, incidence=incidence), axial).std())

    expected = float(axial.axial_sigma(np.array(0.7), np.array(0.0)))
    assert spread(0.7, 0.0) == pytest.approx(expected, rel=0.1)
    assert spread(0.7, 0.0) < spread(2.0, 0.0)
    assert spread(0.7, 0.0) < spread(0.7, 1.4)


def test_depth_comes_in_steps_of_disparity(perfect_sensor: SensorNoise) -> None:
    noise = replace(perfect_sensor, axial_floor=0.002, disparity_step=0.125)
    camera = Camera()
    steps = camera.focal * camera.baseline / measure(wall(), noise) / 0.125
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-6)
    assert len(np.unique(np.rint(steps))) > 3


def test_loss_grows_with_incidence_and_is_larger_on_glass() -> None:
    noise, angles = SensorNoise(), np.radians(np.linspace(0.0, 89.0, 50))
    assert (np.diff(noise.matt_loss(angles)) > 0.0).all()
    assert (np.diff(noise.glass_loss(angles)) >= 0.0).all()
    assert noise.matt_loss(np.radians(noise.grazing)) == pytest.approx(0.5)
    assert (noise.glass_loss(angles[:40]) > noise.matt_loss(angles[:40])).all()


def test_glass_loses_the_stated_share_in_patches(perfect_sensor: SensorNoise) -> None:
    noise = replace(perfect_sensor, gloss_loss=0.3, gloss_loss_grazing=0.3, gloss_patch=7)
    lost = np.mean([np.isnan(measure(wall(glass=True), noise, seed)) for seed in range(20)], axis=0)
    assert lost.mean() == pytest.approx(0.3, abs=0.02)
    one = np.isnan(measure(wall(glass=True), noise))
    assert (one[:, 1:] == one[:, :-1]).mean() > 0.8  # independent pixels: 0.58
    assert not np.isnan(measure(wall(glass=False), noise)).any()


def test_glass_looks_too_far_by_the_bias(perfect_sensor: SensorNoise) -> None:
    noise = replace(perfect_sensor, gloss_bias=0.004)
    np.testing.assert_allclose(measure(wall(glass=True), noise), 0.704, atol=1e-6)


def test_a_highlight_blinds_the_camera_on_glass_only(perfect_sensor: SensorNoise) -> None:
    noise = replace(perfect_sensor, highlight=6.0)
    mirror = np.full(SHAPE, 1.0)
    mirror[40:50, 40:50] = np.radians(3.0)
    assert np.isnan(measure(replace(wall(glass=True), mirror=mirror), noise)).sum() == 100
    assert not np.isnan(measure(replace(wall(), mirror=mirror), noise)).any()


def test_nothing_returns_from_the_projectors_shadow(perfect_sensor: SensorNoise) -> None:
    assert np.isnan(measure(wall(lit=False), perfect_sensor)).all()


def test_flying_pixels_lie_between_the_surfaces_of_an_edge(perfect_sensor: SensorNoise) -> None:
    depth = np.full(SHAPE, 0.6)
    depth[:, 50:] = 0.8
    measured = measure(replace(wall(), depth=depth), replace(perfect_sensor, mixed_share=0.5))
    between = (measured > 0.601) & (measured < 0.799)
    assert set(np.flatnonzero(between.any(axis=0))) == {49, 50}
    assert between[:, 49:51].mean() == pytest.approx(0.5, abs=0.1)


def test_lateral_noise_frays_edges_by_about_a_pixel(perfect_sensor: SensorNoise) -> None:
    depth = np.full(SHAPE, 0.6)
    depth[:, 50:] = 0.8
    far = measure(replace(wall(), depth=depth), replace(perfect_sensor, lateral_floor=0.8)) > 0.7
    assert 0.1 < far[:, 49].mean() < 0.4
    assert far[:, :45].sum() == 0


@pytest.mark.parametrize("window", [1, 3, 9])
def test_smooth_fields_are_standard_normal(window: int) -> None:
    field = smooth_field((400, 400), window, np.random.default_rng(0))
    assert field.shape == (400, 400)
    assert field.mean() == pytest.approx(0.0, abs=0.1)
    assert field.std() == pytest.approx(1.0, abs=0.05)
    neighbours = np.corrcoef(field[:, 1:].ravel(), field[:, :-1].ravel())[0, 1]
    assert neighbours == pytest.approx(1.0 - 1.0 / window, abs=0.02)
