"""A cell on ROS 2, run with the Python of .venv/ros2, told what to do as `tests.drivers.ros.machine`."""

import sys
import threading
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

sys.path[0] = str(Path(__file__).parents[3])

from tests.drivers.ros import machine  # noqa: E402 - found by the line above
from tests.drivers.ros.scenery import (  # noqa: E402 - likewise
    ACTION,
    BELT,
    CLOUDS,
    EMERGENCY,
    JOINTS,
    POINTS,
    SORTER,
)
from tests.drivers.ros2 import services  # noqa: E402 - likewise
from tests.drivers.ros2.topics import DEPTH, INFO, TRAJECTORY  # noqa: E402 - likewise

rclpy: Any = import_module("rclpy")
DEPTHS = [[500, 0, 600], [700, 800, 900]]
"""Millimetres."""
ABORTED, REJECTED = 4, 5
"""Verdicts on a goal."""
BEST_EFFORT = import_module("rclpy.qos").qos_profile_sensor_data


def message_class(kind: str, group: str = "msg") -> Any:
    package, name = kind.split("/")
    return getattr(import_module(f"{package}.{group}"), name)


class Peer(machine.Machine):
    def __init__(self, node: Any) -> None:
        super().__init__()
        self.node = node

        def advertise(topic: str, kind: str, quality: Any = 10) -> Any:
            return node.create_publisher(message_class(kind), topic, quality)

        def hear(topic: str, kind: str, receive: Any) -> None:
            node.create_subscription(message_class(kind), topic, receive, 10)

        self.clouds = advertise(CLOUDS, "sensor_msgs/PointCloud2", BEST_EFFORT)
        self.depth = advertise(DEPTH, "sensor_msgs/Image", BEST_EFFORT)
        self.info = advertise(INFO, "sensor_msgs/CameraInfo", BEST_EFFORT)
        self.states = advertise(JOINTS, "sensor_msgs/JointState")
        self.reports = advertise(f"{BELT}/object", "std_msgs/Int32")
        self.tf = advertise("/tf", "tf2_msgs/TFMessage")
        self.emergency = advertise(EMERGENCY, "std_msgs/Bool")
        qos = import_module("rclpy.qos")
        latched = qos.QoSProfile(depth=1, durability=qos.DurabilityPolicy.TRANSIENT_LOCAL)
        self.latched = advertise("/latched_stop", "std_msgs/Bool", latched)
        self.latched.publish(message_class("std_msgs/Bool")(data=True))
        self.sorted = advertise(f"{SORTER}/state", "diagnostic_msgs/DiagnosticArray")
        hear(TRAJECTORY, "trajectory_msgs/JointTrajectory", self.follow)
        hear(f"{BELT}/target", "std_msgs/Int32", lambda message: self.advance(message.data))
        hear(f"{BELT}/stop", "std_msgs/Empty", lambda _message: self.halt())
        hear(f"{SORTER}/command", "diagnostic_msgs/KeyValue", lambda m: self.sort(m.key, int(m.value)))
        hear(f"{SORTER}/stop", "std_msgs/Empty", lambda _message: self.press.halt())
        action = import_module("rclpy.action")
        self._action_server = action.ActionServer(
            node,
            message_class("control_msgs/FollowJointTrajectory", "action"),
            ACTION,
            self.execute,
            goal_callback=lambda _goal: action.GoalResponse(
                1 if self.settings.verdict == REJECTED else 2  # REJECT, ACCEPT
            ),
            cancel_callback=lambda _goal: action.CancelResponse(2),  # ACCEPT
            callback_group=import_module("rclpy.callback_groups").ReentrantCallbackGroup(),
        )
        self._move_group = services.MoveGroup(node, self)
        self._services = services.Services(node, self)

    def follow(self, trajectory: Any) -> None:
        self.go(trajectory.joint_names, trajectory.points[-1].positions)

    def execute(self, goal: Any) -> Any:
        result = message_class("control_msgs/FollowJointTrajectory", "action").Result()
        if self.settings.verdict == ABORTED:
            result.error_string = "says the peer"
            goal.abort()
            return result
        self.follow(goal.request.trajectory)
        while not self.arrived:
            if goal.is_cancel_requested:
                self.halt()
                goal.canceled()
                return result
            time.sleep(machine.BEAT)
        goal.succeed()
        return result

    def publish(self, n: int) -> None:
        reporting = self.beat()
        self.tf.publish(self.transforms())
        self.emergency.publish(message_class("std_msgs/Bool")(data=self.settings.emergency))
        if reporting:
            self.states.publish(self.joint_state(self.joints))
            self.states.publish(self.joint_state({"gripper": 0.0}))
            self.reports.publish(message_class("std_msgs/Int32")(data=self.belt))
            self.sorted.publish(self.keys())
            self._services.publish()
        if n % 5 == 0 and self.settings.cloud != "silent":
            self.clouds.publish(self.cloud())
            self.depth.publish(self.image())
            self.info.publish(self.camera_info())

    def stamp(self, ago: float = 0.0) -> Any:
        nanoseconds = self.node.get_clock().now().nanoseconds - int(ago * 1e9)
        return import_module("rclpy.time").Time(nanoseconds=nanoseconds).to_msg()

    def joint_state(self, joints: dict[str, float]) -> Any:
        message = message_class("sensor_msgs/JointState")()
        message.header.stamp = self.stamp()
        message.name, message.position = list(joints), list(joints.values())
        return message

    def transforms(self) -> Any:
        transform = message_class("geometry_msgs/TransformStamped")()
        transform.header.stamp, transform.header.frame_id = self.stamp(), "world"
        transform.child_frame_id = "optical"
        transform.transform.rotation.w = 1.0
        transform.transform.translation.z = float(self.joints["elbow"])
        return message_class("tf2_msgs/TFMessage")(transforms=[transform])

    def keys(self) -> Any:
        message = message_class("diagnostic_msgs/DiagnosticArray")()
        for key, state, text in self.press.report():
            status = message_class("diagnostic_msgs/DiagnosticStatus")(name=key, message=text)
            status.values = [message_class("diagnostic_msgs/KeyValue")(key="state", value=state)]
            message.status.append(status)
        return message

    def cloud(self) -> Any:
        kind = self.settings.cloud
        points = {"empty": POINTS[:0], "nan": np.full_like(POINTS, np.nan)}.get(kind, POINTS)
        message = message_class("sensor_msgs/PointCloud2")()
        message.header.stamp = self.stamp({"stale": 100.0, "ahead": -100.0}.get(kind, 0.0))
        message.header.frame_id = "elsewhere" if kind == "frame" else "optical"
        message.height, message.width = points.shape[:2]
        for number, name in enumerate("xyz"):
            field = message_class("sensor_msgs/PointField")
            message.fields.append(field(name=name, offset=4 * number, datatype=field.FLOAT32, count=1))
        message.point_step, message.row_step = 12, 12 * message.width
        message.data = points.astype("<f4").tobytes()[: -1 if kind == "truncated" else None]
        return message

    def image(self) -> Any:
        message = message_class("sensor_msgs/Image")(encoding="16UC1", height=2, width=3, step=6)
        message.header.stamp, message.header.frame_id = self.stamp(), "optical"
        message.data = np.array(DEPTHS, "<u2").tobytes()[: -1 if self.settings.cloud == "truncated" else None]
        return message

    def camera_info(self) -> Any:
        message = message_class("sensor_msgs/CameraInfo")(height=2, width=3)
        message.k = [500.0, 0.0, 1.0, 0.0, 400.0, 0.5, 0.0, 0.0, 1.0]
        return message


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("peer")
    executor = import_module("rclpy.executors").MultiThreadedExecutor(num_threads=8)
    executor.add_node(node)
    peer = Peer(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    machine.run(peer, peer.publish)


if __name__ == "__main__":
    main()
