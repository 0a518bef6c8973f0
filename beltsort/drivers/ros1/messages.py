"""Classes of ROS 1 messages, including those without a Debian package.

Imported in the node's process only, since it needs genpy and the message packages.
"""

import atexit
import inspect
import shutil
from importlib import import_module
from pathlib import Path
from typing import Any

SEPARATOR = "\n" + "=" * 80 + "\n"
"""Separator between a definition and those that it depends on."""

JOINT_COMMAND = """\
int32 mode
float64[] command
string[] names
int32 POSITION_MODE=1
int32 VELOCITY_MODE=2
int32 TORQUE_MODE=3
int32 RAW_POSITION_MODE=4
"""

TRAJECTORY_GOAL = SEPARATOR.join(
    [
        "Header header\nactionlib_msgs/GoalID goal_id\nFollowJointTrajectoryGoal goal\n",
        "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n",
        "MSG: actionlib_msgs/GoalID\ntime stamp\nstring id\n",
        "MSG: control_msgs/FollowJointTrajectoryGoal\ntrajectory_msgs/JointTrajectory trajectory\n"
        "JointTolerance[] path_tolerance\nJointTolerance[] goal_tolerance\nduration goal_time_tolerance\n",
        "MSG: trajectory_msgs/JointTrajectory\nHeader header\nstring[] joint_names\n"
        "JointTrajectoryPoint[] points\n",
        "MSG: trajectory_msgs/JointTrajectoryPoint\nfloat64[] positions\nfloat64[] velocities\n"
        "float64[] accelerations\nfloat64[] effort\nduration time_from_start\n",
        "MSG: control_msgs/JointTolerance\nstring name\nfloat64 position\nfloat64 velocity\n"
        "float64 acceleration\n",
    ]
)

DEFINITIONS = {
    "diagnostic_msgs/KeyValue": "string key\nstring value\n",
    "baxter_core_msgs/JointCommand": JOINT_COMMAND,
    "control_msgs/FollowJointTrajectoryActionGoal": TRAJECTORY_GOAL,
}


def message_class(kind: str) -> Any:
    """Return the class of a message type, as "std_msgs/Int32"."""
    if kind in DEFINITIONS:
        return _made(kind)
    package, name = kind.split("/")
    return getattr(import_module(f"{package}.msg"), name)


def _made(kind: str) -> Any:
    """Return a class generated from its definition.

    genpy deletes the generated source at exit, which a killed process does not reach, so it is deleted here.
    """
    made = import_module("genpy.dynamic").generate_dynamic(kind, DEFINITIONS[kind])[kind]
    shutil.rmtree(Path(inspect.getfile(made)).parent)
    atexit.unregister(shutil.rmtree)
    return made
