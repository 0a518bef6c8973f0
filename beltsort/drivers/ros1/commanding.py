"""The two interfaces by which arms on ROS 1 are commanded."""

from uuid import uuid4

from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.commanding import Commanding
from beltsort.drivers.ros.joints import Joints
from beltsort.drivers.ros.link import Link, Outgoing, Topics, publication
from beltsort.drivers.ros1.options import Ros1ArmOptions
from beltsort.drivers.ros1.status import RUNNING, SUCCEEDED

POSITION_MODE = 1
"""Position mode of JointCommand."""


class JointCommands:
    """Repeated target positions; without them the arm stops after a timeout (0.2 s on Baxter).

    Parameters
    ----------
    topic
        Topic of baxter_core_msgs/JointCommand.
    """

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.repeats, self.pause = True, 0.0
        self.topics = Topics(publish={topic: "baxter_core_msgs/JointCommand"})
        self._target: Joints = {}

    def begin(self, target: Joints) -> Outgoing:
        """Return the target."""
        self._target = target
        return self.halt(target)

    def again(self) -> Outgoing:
        """Return the target again."""
        return self.halt(self._target)

    def halt(self, joints: Joints) -> Outgoing:
        """Return the command to be at `joints`."""
        positions = [float(position) for position in joints.values()]
        return publication(self.topic, {"mode": POSITION_MODE, "names": list(joints), "command": positions})

    def ended(self, link: Link, deadline: Deadline) -> None:
        """Return None: the end shows only in the joint states."""


class TrajectoryAction:
    """A trajectory of one point, as the goal of an action.

    Parameters
    ----------
    action
        Namespace of a control_msgs/FollowJointTrajectory action.
    seconds
        Duration of a motion, seconds.
    """

    def __init__(self, action: str, seconds: float) -> None:
        self._action, self._seconds = action, seconds
        self.topic = f"{action}/goal"
        self._goal = ""
        self.repeats, self.pause = False, 0.0
        self.topics = Topics(
            publish={
                self.topic: "control_msgs/FollowJointTrajectoryActionGoal",
                f"{action}/cancel": "actionlib_msgs/GoalID",
            },
            subscribe={f"{action}/status": "actionlib_msgs/GoalStatusArray"},
        )

    def begin(self, target: Joints) -> Outgoing:
        """Return a goal with a new id; the server ignores known ids."""
        self._goal = f"beltsort-{uuid4().hex}"
        whole = int(self._seconds)
        point = {
            "positions": [float(position) for position in target.values()],
            "time_from_start": {"secs": whole, "nsecs": int((self._seconds - whole) * 1e9)},
        }
        trajectory = {"joint_names": list(target), "points": [point]}
        return publication(self.topic, {"goal_id": {"id": self._goal}, "goal": {"trajectory": trajectory}})

    def again(self) -> None:
        """Return None: a goal is sent once."""

    def halt(self, _joints: Joints) -> Outgoing:
        """Return the request to cancel every goal."""
        return publication(f"{self._action}/cancel", {"id": ""})

    def ended(self, link: Link, deadline: Deadline) -> str | None:
        """Return the goal's status when it has ended."""
        message = link.newest(f"{self._action}/status", deadline).values["message"]
        for entry in message["status_list"] if message is not None else []:
            if entry["goal_id"]["id"] == self._goal and entry["status"] not in RUNNING:
                verdict = "succeeded" if entry["status"] == SUCCEEDED else f"failed ({entry['status']})"
                return f"the action {verdict} {entry['text']}".strip()
        return None


def commanding(options: Ros1ArmOptions) -> Commanding:
    """Return the interface chosen by the options."""
    if options.joint_command_topic:
        return JointCommands(options.joint_command_topic)
    return TrajectoryAction(options.action, options.seconds)
