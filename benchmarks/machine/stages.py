"""The stages of perception: beltsort's own, and a plain pipeline of Open3D's functions."""

from typing import Any

import numpy as np
import open3d as o3d

from beltsort.cell.protocols import Scan
from beltsort.perception import PerceptionConfig, oriented_normals, vfh
from beltsort.perception.clean import main_clusters, voxel_means, without_outliers
from beltsort.perception.segment import View
from beltsort.perception.vfh import Histogram
from beltsort.sim.config import CellConfig
from benchmarks.machine.plain_vfh import plain_vfh
from benchmarks.machine.stopwatch import Stopwatch

PLANE_TOLERANCE = 0.005  # metres
PLANE_TRIALS = 1000
CLUSTER_CORE = 10  # neighbours


def own_stages(scan: Scan, cell: CellConfig, config: PerceptionConfig, watch: Stopwatch) -> list[Histogram]:
    """Perform the stages of `segment` and `describe`; return the descriptors of all objects."""
    with watch.stage("plane"):
        view = View.of(scan, cell.layout, config)
    with watch.stage("crop"):
        cropped = [view.cropped(position) for position in range(cell.layout.positions)]
    with watch.stage("voxels"):
        candidates = [voxel_means(points, config.voxel) for points in cropped]
    found = [j for j, points in enumerate(candidates) if len(points) >= config.fewest_seen]
    with watch.stage("outliers"):
        cleaned = {j: without_outliers(candidates[j], config) for j in found}
    with watch.stage("clusters"):
        objects = {j: main_clusters(points, config) for j, points in cleaned.items()}
    with watch.stage("finding"):
        labelled = [p for j, p in objects.items() if view.finding(j, p) == "object"]
    eye = view.world_from_camera[:3, 3]
    with watch.stage("normals"):
        normals = [oriented_normals(points, eye, config.normal_neighbours) for points in labelled]
    with watch.stage("descriptor"):
        return [vfh(p, n, viewpoint=eye) for p, n in zip(labelled, normals, strict=True)]


def plain_stages(scan: Scan, cell: CellConfig, config: PerceptionConfig, watch: Stopwatch) -> list[Histogram]:
    """Perform the same steps on the whole cloud, in the order of common tutorials; camera frame."""
    with watch.stage("deproject"):
        cloud = _deprojected(scan, cell)
    with watch.stage("plane"):
        _, belt = cloud.segment_plane(PLANE_TOLERANCE, 3, PLANE_TRIALS)
        cloud = cloud.select_by_index(belt, invert=True)
    with watch.stage("outliers"):
        cloud, _ = cloud.remove_statistical_outlier(config.outlier_neighbours, config.outlier_ratio)
    with watch.stage("clusters"):
        cluster = np.asarray(cloud.cluster_dbscan(config.cluster_gap, CLUSTER_CORE))
        largest = np.argsort(np.bincount(cluster[cluster >= 0]))[::-1][: cell.layout.positions]
        objects = [cloud.select_by_index(np.flatnonzero(cluster == number).tolist()) for number in largest]
    with watch.stage("voxels"):
        objects = [part.voxel_down_sample(config.voxel) for part in objects]
    with watch.stage("normals"):
        for part in objects:
            part.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(config.normal_neighbours))
            part.orient_normals_towards_camera_location(np.zeros(3))
    with watch.stage("descriptor"):
        return [plain_vfh(np.asarray(p.points), np.asarray(p.normals), np.zeros(3)) for p in objects]


def _deprojected(scan: Scan, cell: CellConfig) -> o3d.geometry.PointCloud:
    camera = cell.camera
    depth: Any = np.nan_to_num(scan.points[..., 2]).astype(np.float32)  # typed as no buffer
    centre = (camera.width - 1) / 2.0, (camera.height - 1) / 2.0
    pinhole = o3d.camera.PinholeCameraIntrinsic(
        camera.width, camera.height, camera.focal, camera.focal, *centre
    )
    return o3d.geometry.PointCloud.create_from_depth_image(
        o3d.geometry.Image(depth), pinhole, depth_scale=1.0
    )
