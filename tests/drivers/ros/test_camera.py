"""Scans from a camera on ROS."""

import time

import numpy as np
import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros.arm import RosArm
from beltsort.drivers.ros.camera import RosCamera
from beltsort.errors import CellError
from tests.drivers.ros.rig import PeerRig, await_ready
from tests.drivers.ros.scenery import POINTS, POSES

pytestmark = pytest.mark.process


def test_a_scan_is_what_was_published(camera: RosCamera) -> None:
    now = time.monotonic()
    scan = camera.scan(not_before=now, timeout=10.0)
    np.testing.assert_array_equal(scan.points, POINTS)
    assert scan.frame == "optical"
    assert now <= scan.stamp <= time.monotonic()
    np.testing.assert_array_equal(scan.world_from_camera[:3, :3], np.eye(3))


def test_the_pose_is_the_taught_one_where_the_arm_stands(rig: PeerRig, arm: RosArm) -> None:
    with rig.camera(by_joints=True) as camera:
        for viewpoint, name in enumerate(POSES):
            stop = arm.move_to(viewpoint, f"taught-{name}", timeout=10.0)
            pose = camera.scan(not_before=stop, timeout=10.0).world_from_camera
            np.testing.assert_array_equal(pose, POSES[name])


def test_a_camera_without_a_frame_does_not_tell_its_pose(rig: PeerRig) -> None:
    with rig.camera(world_frame="") as camera:
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
def test_an_unusable_cloud_is_waited_out(rig: PeerRig, camera: RosCamera, cloud: str, said: str) -> None:
    rig.tell(cloud=cloud)
    now = time.monotonic()
    with pytest.raises(CommandError, match=said) as error:
        camera.scan(not_before=now, timeout=1.5)
    assert error.value.outcome is Outcome.NOT_DONE
    rig.tell(cloud="good")
    assert camera.scan(not_before=now, timeout=10.0).stamp >= now


def test_misuse(camera: RosCamera) -> None:
    with pytest.raises(CellError, match=r"\bnot_before\b.*\bnan\b"):
        camera.scan(not_before=float("nan"))


def test_a_world_that_tf_does_not_know(rig: PeerRig) -> None:
    with rig.camera(world_frame="moon") as camera:
        await_ready(camera)
        with pytest.raises(CommandError, match=r"'optical'.*'moon'"):
            camera.scan(not_before=0.0, timeout=5.0)
