"""Another node that looks at a run, with the Python of .venv/ros2: a line of JSON each way.

Told of a transition, it makes it; of a parameter, it tries to set it. It answers with what it has received.
"""

import json
import sys
import threading
import time
from importlib import import_module
from pathlib import Path
from typing import Any

sys.path[0] = str(Path(__file__).parents[2])

from beltsort.drivers.ros.serving import plain  # noqa: E402 - found by the line above
from beltsort.drivers.ros2.messages import interface_class  # noqa: E402 - likewise

rclpy: Any = import_module("rclpy")
qos: Any = import_module("rclpy.qos")
NAME = "/beltsort"
TOPICS = {
    "state": "diagnostic_msgs/DiagnosticArray",
    "belief": "std_msgs/Float64MultiArray",
    "decision": "diagnostic_msgs/DiagnosticArray",
    "markers": "visualization_msgs/MarkerArray",
}
TRANSITIONS = {"configure": 1, "cleanup": 2, "activate": 3, "deactivate": 4}
"""Numbers of lifecycle_msgs/Transition."""
SERVICES = {
    "change_state": "lifecycle_msgs/ChangeState",
    "get_state": "lifecycle_msgs/GetState",
    "set_parameters": "rcl_interfaces/SetParameters",
    "get_parameters": "rcl_interfaces/GetParameters",
}
TIMEOUT, RETRY = 60.0, 10.0


class Peer:
    def __init__(self) -> None:
        self.node = rclpy.create_node("peer")
        self.received: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
        self.clients: dict[str, Any] = {}
        for service, kind in SERVICES.items():
            made = interface_class(kind, "srv")
            self.clients[service] = made, self.node.create_client(made, f"{NAME}/{service}")
        durable = qos.DurabilityPolicy.TRANSIENT_LOCAL
        for topic, kind in TOPICS.items():
            self.node.create_subscription(
                interface_class(kind),
                f"{NAME}/{topic}",
                lambda message, topic=topic: self.receive(topic, message),
                qos.QoSProfile(depth=100, durability=durable),
            )

    def receive(self, topic: str, message: Any) -> None:
        values = plain(message)
        if hasattr(message, "status"):
            values["level"] = message.status[0].level[0]
        self.received[topic].append(values)

    def call(self, service: str, **fields: Any) -> Any:
        """Call a service, again if the answer is lost, as one may be before both sides know each other."""
        made, client = self.clients[service]
        end = time.monotonic() + TIMEOUT
        while time.monotonic() < end:
            if not client.wait_for_service(RETRY):
                continue
            done = threading.Event()
            future = client.call_async(made.Request(**fields))
            future.add_done_callback(lambda _future, done=done: done.set())
            if done.wait(RETRY):
                return future.result()
        raise TimeoutError(service)

    def answer(self, line: dict[str, str]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        if "transition" in line:
            transition = interface_class("lifecycle_msgs/Transition")(id=TRANSITIONS[line["transition"]])
            response = self.call("change_state", transition=transition)
            found["success"] = response.success
        if "parameter" in line:
            kind = interface_class("rcl_interfaces/Parameter")
            name = line["parameter"]
            changed = [kind(name=name)]
            response = self.call("set_parameters", parameters=changed)
            found["success"] = response.results[0].successful
            got = self.call("get_parameters", names=[name])
            found["value"] = list(got.values[0].string_array_value)
        if "ask" in line:
            found["lifecycle"] = self.call("get_state").current_state.label
        return found | self.received


def main() -> None:
    rclpy.init()
    peer = Peer()
    executor = import_module("rclpy.executors").SingleThreadedExecutor()
    executor.add_node(peer.node)
    threading.Thread(target=executor.spin, daemon=True).start()
    print("ready", flush=True)
    for line in sys.stdin:
        print(json.dumps(peer.answer(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
