"""Scans from a camera on ROS 2."""

import dataclasses
import time

import numpy as np
import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros2 import Ros2Arm, Ros2Camera
from beltsort.errors import CellError
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig
from tests.drivers.ros2.topics import DEPTH, INFO

pytestmark = pytest.mark.process


def test_a_scan_is_what_was_published(camera: Ros2Camera) -> None:
    now = time.monotonic()
    scan = camera.scan(not_before=now, timeout=10.0)
    np.testing.assert_array_equal(scan.points, scene.POINTS)
    assert scan.frame == "optical"
    assert now <= scan.stamp <= time.monotonic()
    np.testing.assert_array_equal(scan.world_from_camera[:3, :3], np.eye(3))


def test_the_pose_is_the_taught_one_where_the_arm_stands(rig: Rig, arm: Ros2Arm) -> None:
    with Ros2Camera(scene.camera_by_joints(rig.domain)) as camera:
        for viewpoint, name in enumerate(scene.POSES):
            stop = arm.move_to(viewpoint, f"taught-{name}", timeout=10.0)
            pose = camera.scan(not_before=stop, timeout=10.0).world_from_camera
            np.testing.assert_array_equal(pose, scene.POSES[name])


def test_a_camera_without_a_frame_does_not_tell_its_pose(rig: Rig) -> None:
    with Ros2Camera(dataclasses.replace(scene.camera_by_tf(rig.domain), world_frame="")) as camera:
        assert np.isnan(camera.scan(not_before=time.monotonic(), timeout=10.0).world_from_camera).all()


@pytest.mark.parametrize(
    ("cloud", "said"),
    [
        ("stale", r"/\w+ .*\b1\.5 s\b.*\bstamp\b.* s\b"),
        ("ahead", r"/\w+ .*\b1\.5 s\b.*\blater than its arrival\b.*\bclocks\b"),
        ("empty", r"/\w+ .*\b1\.5 s\b.*\bempty\b"),
        ("nan", r"/\w+ .*\b1\.5 s\b.*\b48 points\b.*\bfinite\b"),
        ("truncated", r"/\w+ .*\b1\.5 s\b.*\btruncated\b"),
        ("frame", r"/\w+ .*\b1\.5 s\b.*'elsewhere'.*'optical'"),
    ],
    ids=["stale scan", "clock ahead", "empty cloud", "NaN-only cloud", "truncated cloud", "other frame"],
)
def test_an_unusable_cloud_is_waited_out(rig: Rig, camera: Ros2Camera, cloud: str, said: str) -> None:
    rig.tell(cloud=cloud)
    now = time.monotonic()
    with pytest.raises(CommandError, match=said) as error:
        camera.scan(not_before=now, timeout=1.5)
    assert error.value.outcome is Outcome.NOT_DONE
    rig.tell(cloud="good")
    assert camera.scan(not_before=now, timeout=10.0).stamp >= now


def test_a_depth_image_is_a_scan(rig: Rig) -> None:
    options = dataclasses.replace(
        scene.camera_by_tf(rig.domain), topic="", depth_topic=DEPTH, info_topic=INFO
    )
    with Ros2Camera(options) as camera:
        points = camera.scan(not_before=time.monotonic(), timeout=10.0).points
        assert points.shape == (2, 3, 3)
        np.testing.assert_allclose(points[0, 2], [0.6 / 500, -0.5 * 0.6 / 400, 0.6])
        assert np.isnan(points[0, 1]).all()
        rig.tell(cloud="truncated")
        with pytest.raises(CommandError, match=r"\bimage is truncated: 11 bytes\b"):
            camera.scan(not_before=time.monotonic(), timeout=1.0)


def test_misuse(camera: Ros2Camera) -> None:
    with pytest.raises(CellError, match=r"\bnot_before\b.*\bnan\b"):
        camera.scan(not_before=float("nan"))


def test_a_world_that_tf_does_not_know(rig: Rig) -> None:
    options = dataclasses.replace(scene.camera_by_tf(rig.domain), world_frame="moon")
    with Ros2Camera(options) as camera:
        camera.connect()
        with pytest.raises(CommandError, match=r"'optical'.*'moon'"):
            camera.scan(not_before=0.0, timeout=2.0)
