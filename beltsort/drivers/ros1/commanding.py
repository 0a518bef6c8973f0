"""The two ways in which arms on ROS 1 take joint positions."""

from typing import Any, Protocol
from uuid import uuid4

from beltsort.drivers.ros.joints import Joints
from beltsort.drivers.ros1.link import Deadline, Link
from beltsort.drivers.ros1.options import Ros1ArmOptions
from beltsort.drivers.ros1.status import RUNNING, SUCCEEDED

POSITION_MODE = 1
"""JointCommand's number of it."""

Post = tuple[str, dict[str, Any]]
"""A topic, and the message for it."""


class Commanding(Protocol):
    """How an arm is told where to go."""

    topic: str
    """Where the arm listens."""
    publish: dict[str, str]
    subscribe: dict[str, str]
    repeats: bool
    """Whether a motion lasts only as long as it is repeated."""

    def begin(self, target: Joints) -> Post:
        """Return what starts a motion."""

    def again(self) -> Post | None:
        """Return what keeps it going, if anything must."""

    def halt(self, joints: Joints) -> Post:
        """Return what ends any motion of an arm that is at `joints`."""

    def ended(self, link: Link, deadline: Deadline) -> str | None:
        """Return what the arm says of how the motion ended; None if it runs, or the arm does not say."""


class JointCommands:
    """Positions, repeated: an arm that hears nothing for a while (0.2 s on Baxter) stops by itself.

    Parameters
    ----------
    topic
        Takes baxter_core_msgs/JointCommand.
    """

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.repeats = True
        self.publish = {topic: "baxter_core_msgs/JointCommand"}
        self.subscribe: dict[str, str] = {}
        self._target: Joints = {}

    def begin(self, target: Joints) -> Post:
        """Return the target."""
        self._target = target
        return self.halt(target)

    def again(self) -> Post:
        """Return the target once more."""
        return self.halt(self._target)

    def halt(self, joints: Joints) -> Post:
        """Return the command to be at `joints`."""
        positions = [float(position) for position in joints.values()]
        return self.topic, {"mode": POSITION_MODE, "names": list(joints), "command": positions}

    def ended(self, link: Link, deadline: Deadline) -> None:
        """Tell nothing: only the joint states do."""


class TrajectoryAction:
    """A trajectory of one point, as a goal of an action.

    Parameters
    ----------
    action
        Namespace of a control_msgs/FollowJointTrajectory action.
    seconds
        How long a motion is to take.
    """

    def __init__(self, action: str, seconds: float) -> None:
        self._action, self._seconds = action, seconds
        self.topic = f"{action}/goal"
        self._goal = ""
        self.repeats = False
        self.publish = {
            self.topic: "control_msgs/FollowJointTrajectoryActionGoal",
            f"{action}/cancel": "actionlib_msgs/GoalID",
        }
        self.subscribe = {f"{action}/status": "actionlib_msgs/GoalStatusArray"}

    def begin(self, target: Joints) -> Post:
        """Return a new goal; one that the server knows would be ignored."""
        self._goal = f"beltsort-{uuid4().hex}"
        whole = int(self._seconds)
        point = {
            "positions": [float(position) for position in target.values()],
            "time_from_start": {"secs": whole, "nsecs": int((self._seconds - whole) * 1e9)},
        }
        trajectory = {"joint_names": list(target), "points": [point]}
        return self.topic, {"goal_id": {"id": self._goal}, "goal": {"trajectory": trajectory}}

    def again(self) -> None:
        """Return nothing: a goal is given once."""

    def halt(self, _joints: Joints) -> Post:
        """Return the request to cancel every goal."""
        return f"{self._action}/cancel", {"id": ""}

    def ended(self, link: Link, deadline: Deadline) -> str | None:
        """Return the goal's status when it has ended."""
        message = link.newest(f"{self._action}/status", deadline).values["message"]
        for entry in message["status_list"] if message is not None else []:
            if entry["goal_id"]["id"] == self._goal and entry["status"] not in RUNNING:
                verdict = "succeeded" if entry["status"] == SUCCEEDED else f"failed ({entry['status']})"
                return f"the action {verdict} {entry['text']}".strip()
        return None


def commanding(options: Ros1ArmOptions) -> Commanding:
    """Return the way that the options choose."""
    if options.joint_command_topic:
        return JointCommands(options.joint_command_topic)
    return TrajectoryAction(options.action, options.seconds)
