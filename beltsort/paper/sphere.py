"""The half-sphere of viewpoints with what an arm reaches of it: the left side of the paper's Fig. 1."""

from beltsort.errors import ViewpointError
from beltsort.viewpoints import Sampling, ViewpointMap, map_viewpoints
from beltsort.viewpoints.arm import Arm, load_pinocchio
from beltsort.viewpoints.robots import robot_urdf

POINTS, VIEWPOINTS = 100, 3
LOWEST = 20.0  # degrees; below, cups and belt are in the camera's way
ROBOT, BASE = "ur5", (-0.4, 0.0, 0.2, 0.0)  # metres and degrees; not the paper's robot or place


def reached_sphere() -> tuple[ViewpointMap, str]:
    """Return the map of viewpoints, and what counts as reachable in words.

    Without the extra `ik` every point above `LOWEST` does.
    """
    arm = _arm()
    if arm is None:
        said = f"everything above {LOWEST:g} degrees; the extra `ik` would tell what an arm reaches"
    else:
        x, y, z, _yaw = BASE
        said = f"what a {ROBOT.upper()} based at ({x:g}, {y:g}, {z:g}) m reaches above {LOWEST:g} degrees"
    return map_viewpoints(Sampling(count=POINTS), VIEWPOINTS, lowest=LOWEST, reachable=arm), said


def _arm() -> Arm | None:
    try:
        load_pinocchio()
        urdf, tip = robot_urdf(ROBOT)
    except ViewpointError:
        return None
    return Arm(urdf, tip, BASE)
