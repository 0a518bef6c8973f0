"""Inverse kinematics: what is said to be reached is, what can be reached is found."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from beltsort import ArgumentError
from beltsort.errors import ViewpointError
from beltsort.geometry import Pose, look_at, on_sphere
from beltsort.viewpoints import map_viewpoints
from beltsort.viewpoints.arm import Arm
from beltsort.viewpoints.robots import ROBOTS, robot_urdf
from tests.laws import cases

from .gantry import TIP, depth_inside, gantry

law = cases(40)

BASE = (-0.4, 0.1, 0.0, 20.0)
LENGTHS = st.floats(-0.4, 0.4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("urdf")


def view(azimuth: float, elevation: float) -> Pose:
    return look_at(on_sphere(azimuth, elevation, 0.7, np.zeros(3)), np.zeros(3))


def plain(joints: np.ndarray | None) -> list[float] | None:
    return None if joints is None else joints.tolist()


def off_by(one: Pose, other: Pose) -> float:
    return float(np.linalg.norm(pin.log6(pin.SE3(np.linalg.inv(one) @ other)).vector))


def random_joints(model: pin.Model, seed: int) -> np.ndarray:
    span = model.upperPositionLimit - model.lowerPositionLimit
    joints: np.ndarray = model.lowerPositionLimit + span * np.random.default_rng(seed).random(model.nq)
    return joints


@pytest.mark.slow
@pytest.mark.parametrize("last_joint", ["revolute", "continuous"])
@law
@given(
    azimuth=st.floats(-180, 180),
    elevation=st.floats(5, 85),
    base=st.tuples(LENGTHS, LENGTHS, LENGTHS, st.floats(-180, 180)),
)
def test_the_gantry_reaches_its_box_and_nothing_else(
    folder: Path, last_joint: str, azimuth: float, elevation: float, base: tuple[float, float, float, float]
) -> None:
    pose = view(azimuth, elevation)
    inside = depth_inside(pose[:3, 3], base)
    assume(abs(inside) > 1e-3)
    assert Arm(gantry(folder, last_joint), TIP, base)(pose) == (inside > 0.0)


@pytest.mark.parametrize("robot", ROBOTS)
def test_what_a_robot_can_do_is_found_within_its_limits(robot: str) -> None:
    arm = Arm(*robot_urdf(robot), BASE)
    model = pin.buildModelFromUrdf(str(arm.urdf))
    for seed in range(20):
        pose = arm.camera_at(random_joints(model, seed))
        joints = arm.joints(pose)
        assert joints is not None
        assert off_by(arm.camera_at(joints), pose) < arm.tolerance
        assert (joints >= model.lowerPositionLimit).all()
        assert (joints <= model.upperPositionLimit).all()


@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS)
def test_a_robot_far_away_reaches_nothing_and_a_near_one_its_side(robot: str) -> None:
    urdf, tip = robot_urdf(robot)
    assert not Arm(urdf, tip, (-5.0, 0.0, 0.0, 0.0))(view(180.0, 45.0))
    views = map_viewpoints(viewpoints=1, reachable=Arm(urdf, tip, (-0.7, 0.0, 0.0, 0.0)))
    assert 5 < views.reachable.sum() < 74
    assert views.points[views.reachable, 0].mean() < -0.1


def test_the_answer_does_not_depend_on_what_was_asked_before() -> None:
    panda = robot_urdf("panda")
    poses = [view(azimuth, 40.0) for azimuth in range(0, 360, 45)]
    one, other = Arm(*panda, BASE), Arm(*panda, BASE)
    forth = [one.joints(pose) for pose in poses]
    back = [other.joints(pose) for pose in reversed(poses)]
    assert [found is None for found in forth] not in ([True] * 8, [False] * 8)
    assert [plain(found) for found in forth] == [plain(found) for found in reversed(back)]


def test_the_base_frame_turns_with_yaw(folder: Path) -> None:
    urdf = gantry(folder)
    straight, turned = Arm(urdf, TIP, (0.0, 0.0, 0.0, 0.0)), Arm(urdf, TIP, (0.1, 0.2, 0.3, 90.0))
    joints = np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(straight.camera_at(joints)[:3, 3], [0.1, 0.2, 0.3], atol=1e-12)
    np.testing.assert_allclose(turned.camera_at(joints)[:3, 3], [-0.1, 0.3, 0.6], atol=1e-12)


def test_what_is_refused(folder: Path) -> None:
    urdf = gantry(folder)
    with pytest.raises(ViewpointError, match=r"frame 'link66'.*\blink6, "):
        Arm(urdf, "link66", BASE)(view(0.0, 45.0))
    (folder / "none.urdf").write_text("<robot/>")
    with pytest.raises(ViewpointError, match=r"URDF .*\bnone\.urdf\b"):
        Arm(folder / "none.urdf", TIP, BASE)(view(0.0, 45.0))
    with pytest.raises(ViewpointError, match=r"URDF .*\babsent\.urdf\b"):
        Arm(folder / "absent.urdf", TIP, BASE)(view(0.0, 45.0))
    with pytest.raises(ViewpointError, match=r"gantry_floating\.urdf\b.*joint.*limits"):
        Arm(gantry(folder, "floating"), TIP, BASE)(view(0.0, 45.0))
    with pytest.raises(ArgumentError, match=r"\bbase\b.*\bnan\b.*\bx, y, z\b"):
        Arm(urdf, TIP, (0.0, 0.0, 0.0, np.nan))
    with pytest.raises(ArgumentError, match=r"\btolerance\b.*\b0\.0\b.*\b1e-4\b"):
        Arm(urdf, TIP, BASE, tolerance=0.0)
    with pytest.raises(ArgumentError, match=r"\b0 restarts\b.*\b60 iterations\b.*\b1\b"):
        Arm(urdf, TIP, BASE, restarts=0)


def test_unknown_robots_name_the_known_ones() -> None:
    with pytest.raises(ViewpointError, match=r"robot 'puma'.*baxter, panda, ur5\b.*URDF"):
        robot_urdf("puma")
