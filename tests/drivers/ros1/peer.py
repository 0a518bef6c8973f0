"""A cell on ROS 1: `python -m tests.drivers.ros1.peer`, told what to do as `tests.drivers.ros.machine`."""

from importlib import import_module
from typing import Any

import numpy as np

from beltsort.drivers.ros.clouds import packed
from beltsort.drivers.ros1.messages import message_class
from beltsort.drivers.ros1.status import RUNNING, SUCCEEDED
from tests.drivers.ros import machine
from tests.drivers.ros.scenery import ACTION, BELT, CLOUDS, EMERGENCY, JOINTS, POINTS, SORTER
from tests.drivers.ros1.scene import COMMAND

rospy: Any = import_module("rospy")
NUMBERS = {machine.ACTIVE: RUNNING[1], machine.SUCCEEDED: SUCCEEDED, machine.ABORTED: 4, machine.REJECTED: 5}


class Peer(machine.Machine):
    def __init__(self) -> None:
        super().__init__()
        self.goal: str | None = None
        self.verdict = 1
        advertise = rospy.Publisher
        self.clouds = advertise(CLOUDS, message_class("sensor_msgs/PointCloud2"), queue_size=1)
        self.states = advertise(JOINTS, message_class("sensor_msgs/JointState"), queue_size=10)
        self.reports = advertise(f"{BELT}/object", message_class("std_msgs/Int32"), queue_size=10)
        self.tf = advertise("/tf", message_class("tf2_msgs/TFMessage"), queue_size=10)
        self.emergency = advertise(EMERGENCY, message_class("std_msgs/Bool"), queue_size=1)
        goal_states = message_class("actionlib_msgs/GoalStatusArray")
        self.status = advertise(f"{ACTION}/status", goal_states, queue_size=1)
        self.sorted = advertise(f"{SORTER}/state", goal_states, queue_size=10)
        hear = rospy.Subscriber
        hear(COMMAND, message_class("baxter_core_msgs/JointCommand"), self.commanded)
        goal = message_class("control_msgs/FollowJointTrajectoryActionGoal")
        hear(f"{ACTION}/goal", goal, self.given_goal)
        hear(f"{ACTION}/cancel", message_class("actionlib_msgs/GoalID"), lambda _message: self.halt())
        hear(f"{BELT}/target", message_class("std_msgs/Int32"), lambda message: self.advance(message.data))
        hear(f"{BELT}/stop", message_class("std_msgs/Empty"), lambda _message: self.halt())
        hear(f"{SORTER}/command", message_class("diagnostic_msgs/KeyValue"), self.key)
        hear(f"{SORTER}/stop", message_class("std_msgs/Empty"), lambda _message: self.press.halt())

    def commanded(self, message: Any) -> None:
        self.go(message.names, message.command)

    def key(self, message: Any) -> None:
        self.sort(message.key, int(message.value))

    def given_goal(self, message: Any) -> None:
        self.goal, self.verdict = message.goal_id.id, 1
        if self.settings.verdict == 3:
            trajectory = message.goal.trajectory
            self.go(trajectory.joint_names, trajectory.points[-1].positions)

    def publish(self, n: int) -> None:
        reporting = self.beat()
        if self.arrived and self.goal is not None:
            self.verdict = self.settings.verdict
        self.tf.publish(self.transforms())
        self.emergency.publish(self.settings.emergency)
        if reporting:
            self.report(n)
        if n % 5 == 0 and self.settings.cloud != "silent":
            self.clouds.publish(self.cloud())

    def report(self, n: int) -> None:
        self.states.publish(self.joint_state(self.joints))
        self.states.publish(self.joint_state({"gripper": 0.0}))
        self.reports.publish(self.belt)
        keys = [(key, NUMBERS[state], text) for key, state, text in self.press.report()]
        self.sorted.publish(self.goal_states(keys))
        if n % 5 == 0:
            goals = [] if self.goal is None else [(self.goal, self.verdict, "says the peer")]
            self.status.publish(self.goal_states(goals))

    def joint_state(self, joints: dict[str, float]) -> Any:
        message = message_class("sensor_msgs/JointState")()
        message.header.stamp = rospy.Time.now()
        message.name, message.position = list(joints), list(joints.values())
        return message

    def transforms(self) -> Any:
        message = message_class("tf2_msgs/TFMessage")()
        transform = message_class("geometry_msgs/TransformStamped")()
        transform.header.stamp, transform.header.frame_id = rospy.Time.now(), "world"
        transform.child_frame_id = "optical"
        transform.transform.rotation.w = 1.0
        transform.transform.translation.z = self.joints["elbow"]
        message.transforms = [transform]
        return message

    def goal_states(self, goals: list[tuple[str, int, str]]) -> Any:
        message = message_class("actionlib_msgs/GoalStatusArray")()
        for goal, number, text in goals:
            status = message_class("actionlib_msgs/GoalStatus")()
            status.goal_id.id, status.status, status.text = goal, number, text
            message.status_list.append(status)
        return message

    def cloud(self) -> Any:
        kind = self.settings.cloud
        points = {"empty": POINTS[:0], "nan": np.full_like(POINTS, np.nan)}.get(kind, POINTS)
        content = packed(points)
        message = message_class("sensor_msgs/PointCloud2")()
        delay = {"stale": 100.0, "ahead": -100.0}.get(kind, 0.0)
        message.header.stamp = rospy.Time.now() - rospy.Duration.from_sec(delay)
        message.header.frame_id = "elsewhere" if kind == "frame" else "optical"
        message.height, message.width = content.height, content.width
        for name, (offset, number) in content.fields.items():
            message.fields.append(message_class("sensor_msgs/PointField")(name, offset, number, 1))
        message.point_step, message.row_step = content.point_step, content.row_step
        message.data = bytes(content.data)[: -1 if kind == "truncated" else None]
        return message


def main() -> None:
    rospy.init_node("peer", disable_signals=True, disable_rosout=True)
    peer = Peer()
    machine.run(peer, peer.publish)


if __name__ == "__main__":
    main()
