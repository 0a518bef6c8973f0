"""A reference controller on ROS 2 of a belt that never stops: `python -m beltsort.testing.ros2_controller`.

It needs rclpy and std_msgs in the Python that runs it. It prints its topics as one line of JSON, reads
buttons of the operator's panel from standard input, and ends with standard input.
"""

from argparse import ArgumentParser, Namespace
from collections import deque
from collections.abc import Sequence
from importlib import import_module
from threading import Thread
from typing import Any

from beltsort.drivers.fieldbus.diversions import DiversionReply, DiversionRequest
from beltsort.drivers.ros2.diversion_messages import KIND, decode_request, encode_reply
from beltsort.drivers.ros2.messages import interface_class
from beltsort.drivers.ros2.options import Ros2DiverterOptions
from beltsort.testing.diverting import DivertingMachine
from beltsort.testing.serving import Panel, add_machine_options, run, serve

QUEUE = 10
"""Number of requests that may wait for their reply."""


class DiversionTopics:
    """The topics of requests and replies.

    Parameters
    ----------
    node
        Of rclpy.
    request_topic, reply_topic
        Their names.
    """

    def __init__(self, node: Any, request_topic: str, reply_topic: str) -> None:
        qos = import_module("rclpy.qos")
        self._kind = interface_class(KIND)
        self._requests: deque[DiversionRequest] = deque(maxlen=QUEUE)
        requested = qos.QoSProfile(depth=QUEUE, reliability=qos.ReliabilityPolicy.RELIABLE)
        node.create_subscription(self._kind, request_topic, self._receive, requested)
        kept = qos.QoSProfile(
            depth=1,
            reliability=qos.ReliabilityPolicy.RELIABLE,
            durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
        )
        self._replies = node.create_publisher(self._kind, reply_topic, kept)

    async def request(self) -> DiversionRequest | None:
        """Return the oldest request that was not returned yet, or None."""
        return self._requests.popleft() if self._requests else None

    async def publish(self, reply: DiversionReply) -> None:
        """Publish a reply."""
        self._replies.publish(self._kind(data=encode_reply(reply)))

    def _receive(self, message: Any) -> None:
        request = decode_request(message.data)
        if request is not None:
            self._requests.append(request)


def parsed(arguments: Sequence[str] | None = None) -> Namespace:
    """Return the options on the command line."""
    parser = ArgumentParser(
        prog="python -m beltsort.testing.ros2_controller",
        description="A reference controller on ROS 2 of a belt that never stops.",
    )
    for name, topic in (
        ("--request-topic", Ros2DiverterOptions.request_topic),
        ("--reply-topic", Ros2DiverterOptions.reply_topic),
    ):
        parser.add_argument(name, default=topic, metavar="NAME", help="(default: %(default)s)")
    add_machine_options(parser)
    parser.set_defaults(diverters=DivertingMachine.diverters)
    return parser.parse_args(arguments)


async def main(arguments: Namespace) -> None:
    """Serve until standard input ends."""
    rclpy: Any = import_module("rclpy")
    rclpy.init(args=[])
    node = rclpy.create_node("diverter")
    topics = DiversionTopics(node, arguments.request_topic, arguments.reply_topic)
    receiving = Thread(target=rclpy.spin, args=[node])
    receiving.start()
    try:
        announcement = {"request_topic": arguments.request_topic, "reply_topic": arguments.reply_topic}
        await serve(Panel(arguments), announcement, None, topics)
    finally:
        rclpy.shutdown()
        receiving.join()


if __name__ == "__main__":
    run(main(parsed()))
