"""A cell on ROS 1: `python -m tests.drivers.ros1.peer`, told what to do by lines of JSON.

{"cloud": "good" | "stale" | "ahead" | "empty" | "nan" | "truncated" | "silent" | "frame"},
{"offset": radians}, {"speed": radians a second}, {"verdict": GoalStatus},
{"travel": seconds of the belt}, {"emergency": whether the emergency stop is pressed},
{"sort": seconds of the sorter}, {"full": whether its bins are},
{"stuck": whether the belt does not move}, {"overshoot": whether it goes one object too far},
{"mute": whether it acts on the next command, but reports nothing from then on}

Each line is answered by one that tells the state of the world, and how many times it has published.
"""

import json
import sys
import threading
import time
from importlib import import_module
from typing import Any

import numpy as np

from beltsort.drivers.ros.clouds import packed
from beltsort.drivers.ros1.messages import message_class
from tests.drivers.ros1.press import Press
from tests.drivers.ros1.scene import (
    ACTION,
    BELT,
    CLOUDS,
    COMMAND,
    EMERGENCY,
    HOME,
    JOINTS,
    POINTS,
    SORTER,
    Settings,
)

rospy: Any = import_module("rospy")
BEAT = 0.02


class Peer:
    def __init__(self) -> None:
        self.settings = Settings()
        self.joints = dict(HOME)
        self.target = dict(HOME)
        self.goal: str | None = None
        self.verdict = 1
        self.object, self.arrives = 0, 0.0
        self.press = Press(self.settings)
        self.told = False
        self.beats = 0
        advertise = rospy.Publisher
        self.clouds = advertise(CLOUDS, message_class("sensor_msgs/PointCloud2"), queue_size=1)
        self.states = advertise(JOINTS, message_class("sensor_msgs/JointState"), queue_size=10)
        self.belt = advertise(f"{BELT}/object", message_class("std_msgs/Int32"), queue_size=10)
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
        hear(f"{BELT}/target", message_class("std_msgs/Int32"), self.advanced)
        hear(f"{BELT}/stop", message_class("std_msgs/Empty"), lambda _message: self.halt())
        hear(f"{SORTER}/command", message_class("diagnostic_msgs/KeyValue"), self.sort)
        hear(f"{SORTER}/stop", message_class("std_msgs/Empty"), lambda _message: self.press.halt())

    def commanded(self, message: Any) -> None:
        self.go(message.names, message.command)

    def given_goal(self, message: Any) -> None:
        self.goal, self.verdict = message.goal_id.id, 1
        if self.settings.verdict == 3:
            trajectory = message.goal.trajectory
            self.go(trajectory.joint_names, trajectory.points[-1].positions)

    def go(self, names: list[str], positions: list[float]) -> None:
        self.told = True
        self.target = {name: at + self.settings.offset for name, at in zip(names, positions, strict=True)}

    def halt(self) -> None:
        self.target, self.arrives = dict(self.joints), float("inf")

    def sort(self, message: Any) -> None:
        self.told = True
        self.press.told(message)

    def advanced(self, message: Any) -> None:
        self.told = True
        if not self.settings.stuck:
            self.object = message.data + self.settings.overshoot
            self.arrives = time.monotonic() + self.settings.travel

    def beat(self, n: int) -> None:
        self.beats += 1
        step = self.settings.speed * BEAT
        for name, at in self.target.items():
            self.joints[name] += float(np.clip(at - self.joints[name], -step, step))
        arrived = self.joints == self.target
        if arrived and self.goal is not None:
            self.verdict = self.settings.verdict
        self.press.beat()
        self.tf.publish(self.transforms())
        self.emergency.publish(self.settings.emergency)
        self.told &= self.settings.mute
        if not self.told:
            self.report(n)
        if n % 5 == 0 and self.settings.cloud != "silent":
            self.clouds.publish(self.cloud())

    def report(self, n: int) -> None:
        self.states.publish(self.joint_state(self.joints))
        self.states.publish(self.joint_state({"gripper": 0.0}))
        self.belt.publish(self.object if time.monotonic() >= self.arrives else -1)
        self.sorted.publish(self.press.report())
        if n % 5 == 0:
            self.status.publish(self.goal_states())

    def world(self) -> dict[str, Any]:
        """What an onlooker sees."""
        travelling = time.monotonic() < self.arrives
        moving = self.joints != self.target
        busy = {"arm": moving, "belt": travelling, "sorter": self.press.busy}
        return {
            "joints": self.joints,
            "object": self.object,
            "bins": self.press.bins,
            "busy": busy,
            "halted": self.arrives == float("inf"),
            "beats": self.beats,
        }

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

    def goal_states(self) -> Any:
        message = message_class("actionlib_msgs/GoalStatusArray")()
        if self.goal is not None:
            status = message_class("actionlib_msgs/GoalStatus")()
            status.goal_id.id, status.status, status.text = self.goal, self.verdict, "says the peer"
            message.status_list = [status]
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

    def listen() -> None:
        for line in sys.stdin:
            for name, value in json.loads(line).items():
                setattr(peer.settings, name, value)
            print(json.dumps(peer.world()), flush=True)

    threading.Thread(target=listen, daemon=True).start()
    n = 0
    while not rospy.is_shutdown():
        peer.beat(n)
        if n == 0:
            print("ready", flush=True)
        n += 1
        time.sleep(BEAT)


if __name__ == "__main__":
    main()
