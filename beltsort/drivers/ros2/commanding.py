"""The interfaces by which arms on ROS 2 are commanded: a trajectory of one point, or a goal of MoveIt's."""

from collections.abc import Callable
from typing import Any
from uuid import uuid4

from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.commanding import Commanding
from beltsort.drivers.ros.joints import Joints
from beltsort.drivers.ros.link import Link, Outgoing, Topics, publication
from beltsort.drivers.ros2.options import Ros2ArmOptions

STOP_SECONDS = 0.2
"""Duration of the trajectory that holds an arm where it is, seconds."""

RUNNING = (0, 1, 2, 3)
"""Unknown, accepted, executing and canceling, numbers of action_msgs/GoalStatus."""

NAMES = {4: "succeeded", 5: "was canceled", 6: "was aborted"}


class TrajectoryTopic:
    """The topic of a joint_trajectory_controller, which follows the newest trajectory.

    Parameters
    ----------
    topic
        Topic of trajectory_msgs/JointTrajectory.
    seconds
        Duration of a motion, seconds.
    """

    def __init__(self, topic: str, seconds: float) -> None:
        self.topic, self._seconds = topic, seconds
        self.topics = Topics(publish={topic: "trajectory_msgs/JointTrajectory"})
        self.repeats, self.pause = False, 0.0

    def begin(self, target: Joints) -> Outgoing:
        """Return the trajectory to the target."""
        return publication(self.topic, trajectory(target, self._seconds))

    def again(self) -> None:
        """Return None: a trajectory is sent once."""

    def halt(self, joints: Joints) -> Outgoing:
        """Return a trajectory that holds the arm at `joints`."""
        return publication(self.topic, trajectory(joints, STOP_SECONDS))

    def ended(self, link: Link, deadline: Deadline) -> None:
        """Return None: the end shows only in the joint states."""


class GoalAction:
    """A motion as the goal of an action.

    The end of a goal is known from its result, or, if that was lost, from the action's status topic, which
    keeps the status of recent goals.

    Parameters
    ----------
    action
        Namespace of the action.
    kind
        Its type.
    goal
        Function of the target that returns a goal.
    pause
        Longest time for which the arm may plan a motion before it begins, seconds.
    """

    def __init__(
        self, action: str, kind: str, goal: Callable[[Joints], dict[str, Any]], pause: float = 0.0
    ) -> None:
        self.topic, self._make, self._goal = action, goal, ""
        self._status = f"{action}/_action/status"
        self.topics = Topics(
            subscribe={self._status: "action_msgs/msg/GoalStatusArray"}, actions={action: kind}
        )
        self.repeats, self.pause = False, pause

    def begin(self, target: Joints) -> Outgoing:
        """Return a goal with a new id."""
        self._goal = uuid4().hex
        arguments = {"action": self.topic, "goal_id": self._goal, "goal": self._make(target)}
        return Outgoing(self.topic, "send_goal", arguments)

    def again(self) -> None:
        """Return None: a goal is sent once."""

    def halt(self, _joints: Joints) -> Outgoing:
        """Return the request to cancel every goal."""
        return Outgoing(self.topic, "cancel_goals", {"action": self.topic})

    def ended(self, link: Link, deadline: Deadline) -> str | None:
        """Return how the goal has ended, once it has."""
        result = link.newest(f"{self.topic}/result", deadline).values["message"]
        if result is not None and result["id"] == self._goal:
            return f"the action {result['status']} {result['text']}".strip()
        message = link.newest(self._status, deadline).values["message"]
        for entry in message["status_list"] if message is not None else []:
            known = bytes(entry["goal_info"]["goal_id"]["uuid"]).hex() == self._goal
            if known and entry["status"] not in RUNNING:
                return f"the action {NAMES.get(entry['status'], entry['status'])}"
        return None


def trajectory(target: Joints, seconds: float) -> dict[str, Any]:
    """Return a trajectory_msgs/JointTrajectory of one point, which is reached after a time (seconds)."""
    whole = int(seconds)
    point = {
        "positions": [float(position) for position in target.values()],
        "time_from_start": {"sec": whole, "nanosec": int((seconds - whole) * 1e9)},
    }
    return {"joint_names": list(target), "points": [point]}


def motion_plan(target: Joints, options: Ros2ArmOptions) -> dict[str, Any]:
    """Return a goal of moveit_msgs/MoveGroup: plan a motion to joint positions, and execute it.

    Differences ("is_diff") to the current state and scene are sent, and they are empty: MoveIt starts from
    where the arm is, and avoids what it knows of.
    """
    constraints = [
        {
            "joint_name": name,
            "position": float(position),
            "tolerance_above": options.goal_tolerance,
            "tolerance_below": options.goal_tolerance,
            "weight": 1.0,
        }
        for name, position in target.items()
    ]
    return {
        "request": {
            "group_name": options.planning_group,
            "start_state": {"is_diff": True},
            "goal_constraints": [{"joint_constraints": constraints}],
            "num_planning_attempts": 1,
            "allowed_planning_time": options.planning_seconds,
            "max_velocity_scaling_factor": options.velocity_scaling,
            "max_acceleration_scaling_factor": options.acceleration_scaling,
        },
        "planning_options": {
            "planning_scene_diff": {"is_diff": True, "robot_state": {"is_diff": True}},
            "plan_only": False,
        },
    }


def commanding(options: Ros2ArmOptions) -> Commanding:
    """Return the interface chosen by the options."""
    if options.trajectory_topic:
        return TrajectoryTopic(options.trajectory_topic, options.seconds)
    if options.move_action:
        return GoalAction(
            options.move_action,
            "moveit_msgs/MoveGroup",
            lambda target: motion_plan(target, options),
            pause=options.planning_seconds,
        )
    return GoalAction(
        options.action,
        "control_msgs/FollowJointTrajectory",
        lambda target: {"trajectory": trajectory(target, options.seconds)},
    )
