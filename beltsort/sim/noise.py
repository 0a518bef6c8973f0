"""The noise of a structured-light camera, applied to an ideal depth image."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points
from beltsort.sim.config import CellConfig
from beltsort.sim.sensor import Array, Camera, SensorNoise

Flags = NDArray[np.bool_]
T = TypeVar("T", bound=np.generic)

_NORMAL_GRID = np.linspace(-5.0, 5.0, 401)
_NORMAL_CDF = np.array([NormalDist().cdf(x) for x in _NORMAL_GRID])


@dataclass(frozen=True)
class View:
    """Ideal images in a window of the camera's image, all of the window's shape (h, w).

    Attributes
    ----------
    top, left
        Image row and column of the window's first pixel.
    depth
        Metres along the optical axis; NaN where no surface is hit.
    incidence
        Angle between ray and surface normal, radians.
    mirror
        Angle between the normal and the bisector of camera and projector, radians.
    glass
        Whether the surface belongs to an object, which is of glass.
    lit
        Whether the surface is visible from the projector.
    """

    top: int
    left: int
    depth: Array
    incidence: Array
    mirror: Array
    glass: Flags
    lit: Flags


def stacked(parts: Sequence[View]) -> View:
    """Return one view of bands of rows that lie below each other, the topmost first."""

    def stack(image: Callable[[View], NDArray[T]]) -> NDArray[T]:
        return np.concatenate([image(part) for part in parts])

    return View(
        top=parts[0].top,
        left=parts[0].left,
        depth=stack(lambda view: view.depth),
        incidence=stack(lambda view: view.incidence),
        mirror=stack(lambda view: view.mirror),
        glass=stack(lambda view: view.glass),
        lit=stack(lambda view: view.lit),
    )


def smooth_field(shape: tuple[int, int], window: int, rng: np.random.Generator) -> Array:
    """Return standard normal noise that is smooth over `window` pixels (a moving average), shape `shape`."""
    padded = (shape[0] + window, shape[1] + window)
    total = rng.standard_normal(padded).cumsum(axis=0).cumsum(axis=1)
    rows = total[window:] - total[:-window]
    box: Array = rows[:, window:] - rows[:, :-window]
    return box / window


def noisy_depth(view: View, noise: SensorNoise, camera: Camera, rng: np.random.Generator) -> Array:
    """Return one measured depth image of the window, shape (h, w), metres, NaN where there is no return."""
    seen = np.flatnonzero(np.isfinite(view.depth))  # all arrays below are of these n pixels
    source = _displaced(view, seen, noise, rng)
    incidence, glass = view.incidence.flat[source], view.glass.flat[source]
    z = _mixed(view, seen, source, noise, rng)
    z = z + glass * _glass_error(view, noise, rng).flat[seen]
    error = smooth_field(view.depth.shape, noise.axial_window, rng).flat[seen]
    z = _quantised(z + error * noise.axial_sigma(z, incidence), noise, camera)
    lost = ~view.lit.flat[source] | (rng.random(len(seen)) < noise.matt_loss(incidence))
    lost |= glass & _glass_lost(view, seen, source, noise, rng)
    measured = np.full(view.depth.shape, np.nan)
    measured.flat[seen] = np.where(lost, np.nan, z)
    return measured


def measured_points(view: View, config: CellConfig, rng: np.random.Generator) -> Points:
    """Return the organised points of one scan, camera frame, shape (height, width, 3), metres."""
    camera = config.camera
    depth = noisy_depth(view, config.noise, camera, rng)
    height, width = depth.shape
    points = np.full((camera.height, camera.width, 3), np.nan)
    window = points[view.top : view.top + height, view.left : view.left + width]
    window[...] = camera.deproject(depth, view.top, view.left)
    return points


def _displaced(
    view: View, seen: NDArray[np.intp], noise: SensorNoise, rng: np.random.Generator
) -> NDArray[np.intp]:
    """Return the pixel from which each pixel takes its depth (lateral noise), shape (n,)."""
    height, width = view.depth.shape
    sigma = noise.lateral_sigma(view.incidence.flat[seen])
    shift = np.rint(rng.standard_normal((2, len(seen))) * sigma).astype(np.intp)
    rows = np.clip(seen // width + shift[0], 0, height - 1)
    columns = np.clip(seen % width + shift[1], 0, width - 1)
    source = rows * width + columns
    return np.where(np.isfinite(view.depth.flat[source]), source, seen)


def _mixed(
    view: View, seen: NDArray[np.intp], source: NDArray[np.intp], noise: SensorNoise, rng: np.random.Generator
) -> Array:
    """Return the depth at `source`, or a flying pixel's between two surfaces, shape (n,)."""
    near, far = _neighbourhood(view.depth)
    near, far = near.flat[seen], far.flat[seen]
    flying = (far - near > noise.mixed_jump) & (rng.random(len(seen)) < noise.mixed_share)
    return np.where(flying, near + (far - near) * rng.random(len(seen)), view.depth.flat[source])


def _neighbourhood(depth: Array) -> tuple[Array, Array]:
    """Return the least and the greatest depth of each pixel and its four neighbours, shape (h, w) each."""
    near, far = depth.copy(), depth.copy()
    for here, there in (
        (np.s_[1:, :], np.s_[:-1, :]),
        (np.s_[:-1, :], np.s_[1:, :]),
        (np.s_[:, 1:], np.s_[:, :-1]),
        (np.s_[:, :-1], np.s_[:, 1:]),
    ):
        np.fmin(near[here], depth[there], out=near[here])
        np.fmax(far[here], depth[there], out=far[here])
    return near, far


def _glass_error(view: View, noise: SensorNoise, rng: np.random.Generator) -> Array:
    """Return the depth error on glass, smooth over a patch, shape (h, w), metres."""
    return noise.gloss_bias + noise.gloss_depth * smooth_field(view.depth.shape, noise.gloss_patch, rng)


def _glass_lost(
    view: View, seen: NDArray[np.intp], source: NDArray[np.intp], noise: SensorNoise, rng: np.random.Generator
) -> Flags:
    """Return the pixels without return on glass, in patches and in the highlight, shape (n,)."""
    field = smooth_field(view.depth.shape, noise.gloss_patch, rng).flat[seen]
    uniform = np.interp(field, _NORMAL_GRID, _NORMAL_CDF)
    blinded = view.mirror.flat[source] < np.radians(noise.highlight)
    lost: Flags = (uniform < noise.glass_loss(view.incidence.flat[source])) | blinded
    return lost


def _quantised(z: Array, noise: SensorNoise, camera: Camera) -> Array:
    """Round depth to the sensor's steps of disparity, z = focal * baseline / disparity."""
    product = camera.focal * camera.baseline
    return product / (np.rint(product / z / noise.disparity_step) * noise.disparity_step)
