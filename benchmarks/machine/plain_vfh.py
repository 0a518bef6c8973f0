"""The viewpoint feature histogram in plain NumPy, as a reference for the compiled one."""

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points
from beltsort.perception.vfh import Histogram

ANGLE_BINS = 45
VIEWPOINT_BINS = 128
SIZE_BINS_PER_METRE = 100.0


def plain_vfh(
    points: Points,
    normals: Points,
    viewpoint: Points,
    *,
    size_component: bool = True,
    normalize_distance: bool = False,
    raw_counts: bool = False,
    pcl_compatible: bool = False,
) -> Histogram:
    """Return what `beltsort.perception.vfh` returns, of the same arguments; none of them is checked."""
    n = len(points)
    centroid = points.mean(axis=0)
    offset = points - centroid
    distance = _norm(offset)
    pairs = _pair_features(offset, distance, normals)
    framed = ~np.isnan(pairs).any(axis=1)
    pairs, distance = pairs[framed], distance[framed]
    leak = 1.0 if pcl_compatible else 0.0
    if not size_component:
        size = np.zeros(ANGLE_BINS)
    elif normalize_distance:
        largest = np.sqrt((offset**2).sum(axis=1).max() + leak)
        size = _histogram(ANGLE_BINS * distance / largest, ANGLE_BINS)
    else:
        size = _histogram(SIZE_BINS_PER_METRE * distance + 0.5, ANGLE_BINS)
    angles = [_histogram(ANGLE_BINS * (pair + np.pi) / (2.0 * np.pi), ANGLE_BINS) for pair in pairs.T]
    towards_eye = (viewpoint - centroid) / np.sqrt(((viewpoint - centroid) ** 2).sum() + leak)
    view = _histogram(VIEWPOINT_BINS * (normals @ towards_eye + 1.0) / 2.0, VIEWPOINT_BINS)
    per_pair, per_point = (1.0, 1.0) if raw_counts else (100.0 / (n - 1), 100.0 / n)
    return np.concatenate([per_pair * np.concatenate([*angles, size]), per_point * view])


def _pair_features(offset: Points, distance: NDArray[np.float64], normals: Points) -> NDArray[np.float64]:
    """Return theta, cos(alpha), cos(phi) with the centroid, shape (n, 3); NaN where undefined."""
    mean = np.broadcast_to(normals.mean(axis=0), normals.shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        direction = offset / distance[:, None]
        cos_mean = _dot(direction, mean)
        cos_own = _dot(direction, normals)
        swap = np.abs(cos_mean) < np.abs(cos_own)
        u = np.where(swap[:, None], normals, mean)
        other = np.where(swap[:, None], mean, normals)
        v = _cross(np.where(swap[:, None], -offset, offset), u)
        v /= _norm(v)[:, None]
    theta = np.arctan2(_dot(_cross(u, v), other), _dot(u, other))
    return np.stack([theta, _dot(v, other), np.where(swap, -cos_own, cos_mean)], axis=1)


def _histogram(scaled: NDArray[np.float64], bins: int) -> Histogram:
    index = np.clip(np.floor(scaled), 0, bins - 1).astype(np.intp)
    counts: Histogram = np.bincount(index, minlength=bins).astype(np.float64)
    return counts


def _dot(a: Points, b: Points) -> NDArray[np.float64]:
    products: NDArray[np.float64] = np.einsum("ij,ij->i", a, b)
    return products


def _norm(a: Points) -> NDArray[np.float64]:
    length: NDArray[np.float64] = np.sqrt(_dot(a, a))
    return length


def _cross(a: Points, b: Points) -> Points:
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
