"""Ray casting of ideal depth images of belt, cups and objects."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points, Pose, transform
from beltsort.sim.noise import Flags, View, stacked
from beltsort.sim.sensor import Array, Camera
from beltsort.sim.surfaces import Mesh
from beltsort.util.extras import extra

with extra("perception"):
    import open3d
    from open3d.core import Tensor

Floats = NDArray[np.float32]

TALLEST = 0.2  # metres; upper bound of the height of everything on the belt
CLEARANCE = 1e-4  # metres; offset of shadow rays, so that a surface does not shadow itself


class Scene:
    """A belt with cups and objects on it, all in the world frame.

    Parameters
    ----------
    belt
        Corners of the belt's surface, shape (4, 3), in order around it.
    cups, objects
        Meshes; objects are of glass, everything else is matt.
    camera
        The camera.
    """

    def __init__(self, belt: Points, cups: Sequence[Mesh], objects: Sequence[Mesh], camera: Camera) -> None:
        self._camera = camera
        self._projector = np.array([camera.baseline, 0.0, 0.0])
        self._belt = belt
        self._caster = open3d.t.geometry.RaycastingScene()
        for mesh in [Mesh(belt, np.array([[0, 1, 2], [0, 2, 3]])), *cups]:
            self._add(mesh)
        self._first_glass = 1 + len(cups)
        for mesh in objects:
            self._add(mesh)

    def _add(self, mesh: Mesh) -> None:
        vertices, triangles = mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32)
        self._caster.add_triangles(_tensor(vertices), _tensor(triangles))

    def view(self, world_from_camera: Pose) -> View:
        """Return the ideal images of a camera at `world_from_camera`, in the window that shows the belt."""
        return self._view(*self._window(world_from_camera), world_from_camera)

    def rolling_view(self, poses: Sequence[Pose]) -> View:
        """Return the ideal images of a camera that moves while it reads its rows from top to bottom.

        Parameters
        ----------
        poses
            The camera's pose during each of as many equal bands of rows, shape (4, 4) each, in order. A belt
            that moves is a camera that moves the other way.
        """
        windows = [self._window(pose) for pose in (poses[0], poses[-1])]
        rows, columns = (_hull([window[axis] for window in windows]) for axis in (0, 1))
        band = np.minimum(rows.astype(np.intp) * len(poses) // self._camera.height, len(poses) - 1)
        parts = [
            self._view(rows[band == n], columns, pose) for n, pose in enumerate(poses) if (band == n).any()
        ]
        return stacked(parts)

    def _view(self, rows: Array, columns: Array, world_from_camera: Pose) -> View:
        """Return the ideal images in a window of rows and columns."""
        directions = self._directions(rows, columns, world_from_camera)  # (h, w, 3)
        eye = world_from_camera[:3, 3].astype(np.float32)
        rays = np.concatenate([np.broadcast_to(eye, directions.shape), directions], axis=-1)
        hit = self._caster.cast_rays(_tensor(rays))
        depth = hit["t_hit"].numpy()  # directions advance 1 along the optical axis, so this is the depth
        seen = np.isfinite(depth)
        towards, normals = directions[seen], hit["primitive_normals"].numpy()[seen]  # (n, 3) from here on
        points = eye + towards * depth[seen][:, None]
        to_projector = transform(world_from_camera, self._projector).astype(np.float32) - points
        towards, lights = _unit(towards), _unit(to_projector)
        image = partial(_image, seen)
        return View(
            top=int(rows[0]),
            left=int(columns[0]),
            depth=image(depth[seen].astype(np.float64), np.nan),
            incidence=image(_angle(normals, towards), np.nan),
            mirror=image(_angle(normals, _unit(lights - towards)), np.nan),
            glass=image(hit["geometry_ids"].numpy()[seen] >= self._first_glass, False),
            lit=image(self._lit(points + lights * CLEARANCE, to_projector), False),
        )

    def _directions(self, rows: Array, columns: Array, world_from_camera: Pose) -> Floats:
        """Return the world directions of a window's rays, of length 1 along the optical axis, (h, w, 3)."""
        across, down, forward = world_from_camera[:3, :3].T
        x, y = self._camera.slopes(columns, rows)
        sideways: Floats = (x[:, None] * across).astype(np.float32)
        ahead: Floats = (y[:, None] * down + forward).astype(np.float32)
        return sideways + ahead[:, None, :]

    def _window(self, world_from_camera: Pose) -> tuple[Array, Array]:
        """Return the rows and columns of the smallest window that shows the belt and everything on it."""
        camera = self._camera
        tops: Points = self._belt + np.array([0.0, 0.0, TALLEST])
        from_eye = np.vstack([self._belt, tops]) - world_from_camera[:3, 3]
        corners = from_eye @ world_from_camera[:3, :3]
        if corners[:, 2].min() <= 0.0:
            return np.arange(camera.height, dtype=float), np.arange(camera.width, dtype=float)
        u = corners[:, 0] / corners[:, 2] * camera.focal + (camera.width - 1) / 2.0
        v = corners[:, 1] / corners[:, 2] * camera.focal + (camera.height - 1) / 2.0
        return _pixels(v, camera.height), _pixels(u, camera.width)

    def _lit(self, start: Floats, to_projector: Floats) -> Flags:
        """Return whether the line from `start` to the projector is free, shape (n,)."""
        rays = np.concatenate([start, to_projector], axis=-1)
        occluded: Flags = self._caster.test_occlusions(_tensor(rays), tnear=0.0, tfar=1.0).numpy()
        return ~occluded


def _image(seen: Flags, values: NDArray[Any], elsewhere: float) -> NDArray[Any]:
    """Return the image that has `values` at the pixels `seen`, shape (h, w)."""
    image = np.full(seen.shape, elsewhere, dtype=values.dtype)
    image[seen] = values
    return image


def _tensor(array: NDArray[Any]) -> Tensor:
    return Tensor.from_numpy(np.ascontiguousarray(array))


def _pixels(coordinates: Array, size: int) -> Array:
    first = np.clip(np.floor(coordinates.min()), 0, size - 1)
    last = np.clip(np.ceil(coordinates.max()), first, size - 1)
    return np.arange(first, last + 1.0)


def _hull(ranges: Sequence[Array]) -> Array:
    """Return the smallest range of pixels that contains all of `ranges`."""
    return np.arange(min(pixels[0] for pixels in ranges), max(pixels[-1] for pixels in ranges) + 1.0)


def _unit(vectors: Floats) -> Floats:
    length: Floats = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return vectors / length[:, None]


def _angle(a: Floats, b: Floats) -> Floats:
    """Return the angle between the lines along unit vectors `a` and `b`, shape (n, 3), radians, 0 to pi/2."""
    cosine: Floats = np.abs(np.einsum("ij,ij->i", a, b))
    return np.arccos(np.minimum(cosine, np.float32(1.0)))
