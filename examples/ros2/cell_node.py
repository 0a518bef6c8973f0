"""The other side of a cell on ROS 2: arm, camera, belt and sorter in one node of plain rclpy.

Copy this file and replace what is simulated by your hardware. It needs rclpy and the messages imported below,
and nothing of beltsort; the classes say what beltsort expects of each device (docs/ros.md, "Interface of the
other nodes").

    ros2/bin/python cell_node.py              with ROS 2 from wheels
    python3 cell_node.py                      after "source /opt/ros/jazzy/setup.bash"

What the camera sees is rendered by beltsort's simulated cell, in a process of its own (renderer.py) with the
Python that --renderer-python names.
"""

import argparse
import json
import subprocess
import threading
import time
from contextlib import suppress
from pathlib import Path

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, Image, JointState
from std_msgs.msg import Bool, Empty, Int32
from trajectory_msgs.msg import JointTrajectory

HERE = Path(__file__).parent
REPORT_SECONDS = 0.05  # between reports of arm, belt and sorter: 20 Hz; beltsort asks for 10, 5 and 10
SCAN_SECONDS = 0.5  # between depth images; beltsort asks for 1 Hz
OPTICAL_FRAME = "camera_depth_optical_frame"  # x right, y down, z forward


class Arm:
    """Follows trajectories and publishes joint states, as `joint_trajectory_controller` of ros2_control does.

    A new trajectory replaces the one under way: that is how beltsort stops an arm. An arm that is commanded
    by the action control_msgs/FollowJointTrajectory needs none of this: give `action` in the cell file
    instead of `trajectory_topic`.
    """

    def __init__(self, node):
        self.node = node
        self.begin = {"shoulder": 0.9, "elbow": -0.4}  # radians
        self.target, self.began, self.seconds = dict(self.begin), 0.0, 1.0
        self.states = node.create_publisher(JointState, "/joint_states", 10)
        topic = "/joint_trajectory_controller/joint_trajectory"
        node.create_subscription(JointTrajectory, topic, self.follow, 10)
        node.create_timer(REPORT_SECONDS, self.report)

    def joints(self):
        """Return where the joints are, radians."""
        done = min((time.monotonic() - self.began) / self.seconds, 1.0)
        return {name: at + done * (self.target[name] - at) for name, at in self.begin.items()}

    def follow(self, trajectory):
        """Go to the trajectory's one point, in the time that it gives."""
        point = trajectory.points[-1]
        self.begin = self.joints()
        self.target = self.begin | dict(zip(trajectory.joint_names, point.positions, strict=True))
        self.seconds = max(point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec, 1e-3)
        self.began = time.monotonic()

    def report(self):
        """Publish the joint states, also while nothing moves: they tell beltsort when the arm has arrived."""
        joints = self.joints()
        message = JointState(name=list(joints), position=list(joints.values()))
        message.header.stamp = self.node.get_clock().now().to_msg()
        self.states.publish(message)


class Belt:
    """Brings the object of a number to the belt end, and publishes the number of the one that is there.

    The number is absolute, so that a repeated command moves nothing. The belt must keep count over restarts,
    and may only report a number while it stands.
    """

    SECONDS = 0.5  # for one position
    MOVING = -1

    def __init__(self, node):
        self.object, self.target, self.arrives = 0, 0, 0.0
        self.state = node.create_publisher(Int32, "/belt/object", 10)
        node.create_subscription(Int32, "/belt/target", lambda message: self.advance(message.data), 10)
        node.create_subscription(Empty, "/belt/stop", lambda _message: self.stop(), 10)
        node.create_timer(REPORT_SECONDS, self.report)

    def advance(self, number):
        """Go forward to an object; a belt that has passed it stays where it is."""
        if number > self.object:
            self.target, self.arrives = number, time.monotonic() + self.SECONDS * (number - self.object)

    def stop(self):
        """Stop between two objects, if the belt moves, until the next command."""
        if self.target != self.object:
            self.arrives = float("inf")

    def at_end(self):
        """Return the number of the object at the belt end, or MOVING."""
        if time.monotonic() >= self.arrives:
            self.object = self.target
        return self.object if self.target == self.object else self.MOVING

    def report(self):
        """Publish what is at the belt end."""
        self.state.publish(Int32(data=self.at_end()))


class Sorter:
    """Puts the object at the belt end into a bin, once for each key, and publishes what became of each key.

    A command that arrives twice must not sort the next object, so a key that is known is not executed again.
    Remember at least the last 100 keys. If yours forgets them in a restart, restart the node too: beltsort
    recognises another publisher, and asks an operator about a sort that it does not know the end of.
    """

    BINS = 4
    SECONDS = 0.5
    REMEMBERED = 1000

    def __init__(self, node, belt, log):
        self.belt, self.log = belt, log
        self.keys = {}  # key: (state, reason)
        self.acting = None  # key, bin, object, time of the end
        self.taken = -1  # the object that was taken from the belt last
        self.bins = [[] for _ in range(self.BINS)]
        self.states = node.create_publisher(DiagnosticArray, "/sorter/state", 10)
        node.create_subscription(KeyValue, "/sorter/command", lambda m: self.sort(m.key, m.value), 10)
        node.create_subscription(Empty, "/sorter/stop", lambda _message: self.stop(), 10)
        node.create_timer(REPORT_SECONDS, self.report)

    def sort(self, key, value):
        """Begin to sort, unless the key is known, or reject it with a reason: then nothing has moved."""
        if key in self.keys:
            return
        number, bin = self.belt.at_end(), int(value)
        if not 0 <= bin < self.BINS:
            self.keys[key] = "rejected", f"there is no bin {bin}; the bins are 0 to {self.BINS - 1}"
        elif self.acting is not None:
            self.keys[key] = "rejected", "the sorter is busy"
        elif number == Belt.MOVING:
            self.keys[key] = "rejected", "the belt does not stand at an object"
        elif number == self.taken:
            self.keys[key] = "rejected", f"the cup of object {number} is empty"
        else:
            self.keys[key] = "active", ""
            self.acting = key, bin, number, time.monotonic() + self.SECONDS

    def stop(self):
        """Break a sort off: it is "aborted", since an operator has to see where the object is."""
        if self.acting is not None:
            self.keys[self.acting[0]] = "aborted", "stopped on the way"
            self.acting = None

    def report(self):
        """End a sort whose time has come, and publish the state of every key."""
        if self.acting is not None and time.monotonic() >= self.acting[-1]:
            (key, bin, number, _), self.acting = self.acting, None
            self.taken = number
            self.bins[bin].append(number)
            self.keys[key] = "succeeded", ""
            self.log(number, bin)
        for key in list(self.keys)[: -self.REMEMBERED]:
            del self.keys[key]
        message = DiagnosticArray()
        for key, (state, reason) in self.keys.items():
            values = [KeyValue(key="state", value=state)]
            message.status.append(DiagnosticStatus(name=key, message=reason, values=values))
        self.states.publish(message)


class Camera:
    """Publishes depth images with the time at which each exposure began, and the camera's parameters.

    They are published reliably: of large messages that are sent with best effort, many are lost. A driver
    that publishes sensor_msgs/PointCloud2 does as well: give its `topic` in the cell file.
    """

    def __init__(self, node, renderer, state):
        self.node, self.renderer, self.state = node, renderer, state
        self.images = node.create_publisher(Image, "/camera/depth/image_rect", 2)
        self.infos = node.create_publisher(CameraInfo, "/camera/depth/camera_info", 2)

    def run(self):
        """Publish until the node ends."""
        while self.node.context.ok():
            self.publish()
            time.sleep(SCAN_SECONDS)

    def publish(self):
        """Expose and publish one image."""
        stamp = self.node.get_clock().now().to_msg()  # before the state that the image shows
        camera, depths = self.renderer.render(self.state())
        image = Image(
            height=camera["height"], width=camera["width"], encoding="32FC1"
        )  # metres, 0: no return
        image.step, image.data = 4 * image.width, depths
        info = CameraInfo(height=image.height, width=image.width)
        middle = (image.width - 1) / 2, (image.height - 1) / 2
        info.k = [camera["focal"], 0.0, middle[0], 0.0, camera["focal"], middle[1], 0.0, 0.0, 1.0]
        for message in (image, info):
            message.header.stamp, message.header.frame_id = stamp, OPTICAL_FRAME
        self.infos.publish(info)
        self.images.publish(image)


class Renderer:
    """The process in which beltsort's simulated cell shows what the camera sees: see renderer.py."""

    def __init__(self, python, cell_file):
        command = [python, str(HERE / "renderer.py"), str(cell_file)]
        self.process = subprocess.Popen(  # in a session of its own: Ctrl-C is for the node
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        )
        self.classes = {}  # name of the class of each object that was seen

    def render(self, state):
        """Return the camera's parameters, and its depths in metres, float32, row by row."""
        with suppress(BrokenPipeError):  # it has ended already: its output, too
            self.process.stdin.write(json.dumps(state).encode() + b"\n")
            self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError("renderer.py has ended, see above; give --renderer-python one with beltsort")
        camera = json.loads(line)
        self.classes.update(enumerate(camera["classes"], start=state["object"]))
        return camera, self.process.stdout.read(4 * camera["height"] * camera["width"])


def parsed():
    """Return the arguments."""
    parser = argparse.ArgumentParser(description="A simulated cell on ROS 2.")
    parser.add_argument(
        "--renderer-python",
        default="python3",
        metavar="PYTHON",
        help="a Python that has beltsort; default python3",
    )
    parser.add_argument(
        "--cell", type=Path, default=HERE / "cell.toml", help="the cell file; default cell.toml"
    )
    return parser.parse_args()


def main():
    """Start the node."""
    arguments = parsed()
    renderer = Renderer(arguments.renderer_python, arguments.cell)
    rclpy.init()
    node = Node("cell")

    def log(number, bin):
        node.get_logger().info(f"object {number} ({renderer.classes.get(number)}) into bin {bin}")

    arm, belt = Arm(node), Belt(node)
    sorter = Sorter(node, belt, log)

    # What a safety relay reports: published once, and kept for whoever subscribes later.
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_publisher(Bool, "/emergency_stop", kept).publish(Bool(data=False))

    def state():
        return {"joints": arm.joints(), "object": belt.object, "taken": sorter.taken == belt.object}

    camera = Camera(node, renderer, state)
    camera.publish()  # ends here if there is no renderer
    threading.Thread(target=camera.run, daemon=True).start()
    node.get_logger().info("arm, camera, belt and sorter are ready; end with Ctrl-C")
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
