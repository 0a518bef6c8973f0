"""A network between client and controller of diversions on ROS 2 that delays and holds messages back.

Run with the Python of .venv/ros2. It hears the client on the topics of `CLIENT`, and the controller on those
of `MACHINE`. A line on standard input says what befalls the messages, and is answered by a line:
`slow SECONDS` for all; `hold` for requests to divert, until `deliver`.
"""

import json
import os
import sys
import threading
import time
from importlib import import_module
from pathlib import Path
from typing import Any

sys.path[0] = str(Path(__file__).parents[3])

from beltsort.drivers.fieldbus.diversions import DiversionVerb  # noqa: E402 - found by the line above
from beltsort.drivers.ros2.diversion_messages import decode_request  # noqa: E402 - likewise
from beltsort.drivers.ros2.options import Ros2DiverterOptions  # noqa: E402 - likewise

MACHINE = Ros2DiverterOptions(request_topic="/machine/request", reply_topic="/machine/reply")
CLIENT = Ros2DiverterOptions()


class Relay:
    """Passes messages on."""

    def __init__(self, node: Any) -> None:
        self._delay, self._holding = 0.0, False
        self._held: list[Any] = []
        kind = import_module("std_msgs.msg").Int64MultiArray
        qos = import_module("rclpy.qos")
        kept = qos.QoSProfile(depth=1, durability=qos.DurabilityPolicy.TRANSIENT_LOCAL)
        self._requests = node.create_publisher(kind, MACHINE.request_topic, 10)
        self._replies = node.create_publisher(kind, CLIENT.reply_topic, kept)
        node.create_subscription(kind, CLIENT.request_topic, self._request, 10)
        node.create_subscription(kind, MACHINE.reply_topic, self._reply, kept)

    def slow(self, seconds: str) -> None:
        self._delay = float(seconds)

    def hold(self) -> None:
        self._holding = True

    def deliver(self) -> None:
        self._holding = False
        while self._held:
            self._requests.publish(self._held.pop(0))

    def _request(self, message: Any) -> None:
        time.sleep(self._delay)
        request = decode_request(message.data)
        if self._holding and request is not None and request.verb == DiversionVerb.DIVERT:
            self._held.append(message)
        else:
            self._requests.publish(message)

    def _reply(self, message: Any) -> None:
        time.sleep(self._delay)
        self._replies.publish(message)


def main() -> None:
    rclpy: Any = import_module("rclpy")
    rclpy.init(args=[])
    node = rclpy.create_node("relay")
    relay = Relay(node)
    threading.Thread(target=rclpy.spin, args=[node], daemon=True).start()
    print(json.dumps({"topics": [CLIENT.request_topic, CLIENT.reply_topic]}), flush=True)
    for line in sys.stdin:
        fault, *arguments = line.split()
        getattr(relay, fault)(*arguments)
        print(json.dumps({"befalls": fault}), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
