"""A belt that never stops, on ROS 2: requests and replies as messages of two topics."""

import time
from collections.abc import Callable
from math import inf
from threading import Lock
from typing import Self

from beltsort.drivers.deadline import Deadline
from beltsort.drivers.fieldbus.diversions import DiversionReply, DiversionRequest
from beltsort.drivers.fieldbus.diverting_device import DivertingDevice
from beltsort.drivers.fieldbus.link import LinkError
from beltsort.drivers.ros.link import Link, Outgoing, Topics, publication
from beltsort.drivers.ros2.diversion_messages import KIND, decode_reply, encode_request
from beltsort.drivers.ros2.link import Ros2Link
from beltsort.drivers.ros2.options import Ros2DiverterOptions

READ_WAIT = 0.05
"""Longest time for which `DiversionTopics.read` waits for another reply, seconds."""

REPEAT = 0.5
"""Interval at which a request without a reply is published again, seconds."""

IN_TIME = 0.9
"""Part of the timeout of finding the controller after which the error says what was not found."""


class DiversionTopics:
    """A connection to the controller: its two topics, once it has been found.

    It uses a node that outlives it, since another node would have to be found first. What is published before
    the nodes have found each other is lost, so a request without a reply is published again; the controller
    executes it once, by its sequence.

    Parameters
    ----------
    node
        The link to the node, which is connected.
    options
        The topics.
    deadline
        By which the controller must be found.

    Raises
    ------
    LinkError
        If it is not.
    """

    def __init__(self, node: Link, options: Ros2DiverterOptions, deadline: Deadline) -> None:
        self._node, self._options = node, options
        self._number = 0
        self._newest: list[int] = []
        self._request: Outgoing | None = None
        self._repeat = Deadline(REPEAT)
        while not self._receive(deadline):
            if deadline.left() == 0.0:
                raise LinkError(
                    f"no reply on {options.reply_topic} within {deadline.timeout:.3g} s, expected the last "
                    "one of the controller; start it, and let it publish a reply when it starts, reliable "
                    "and kept for those that subscribe later (transient local)"
                )

    def write(self, request: DiversionRequest) -> None:
        """Publish a request."""
        self._request = publication(self._options.request_topic, {"data": encode_request(request)})
        self._repeat = Deadline(REPEAT)
        self._node.send(self._request, Deadline(self._options.answer_timeout))

    def read(self) -> DiversionReply:
        """Return the latest reply, after waiting a moment for another one."""
        deadline, before = Deadline(self._options.answer_timeout), self._number
        self._receive(deadline)
        if self._request is not None and self._number == before and self._repeat.left() == 0.0:
            self._repeat = Deadline(REPEAT)
            self._node.send_once(self._request, deadline)
        return decode_reply(self._newest)

    def close(self) -> None:
        """Do nothing: the node is the device's."""

    def _receive(self, deadline: Deadline) -> bool:
        """Wait a moment for another reply; return whether there is any."""
        values = self._node.newest(
            self._options.reply_topic, deadline, after=self._number, wait=READ_WAIT, not_before=inf
        ).values
        if values["message"] is not None:
            self._number, self._newest = values["number"], values["message"]["data"]
        return self._number > 0


class Ros2Diverter(DivertingDevice):
    """A belt that never stops, with its diverters, on ROS 2: a `DivertingDevice`.

    Parameters
    ----------
    options
        Its topics.
    clock
        The cell's clock, seconds.
    """

    def __init__(self, options: Ros2DiverterOptions, clock: Callable[[], float] = time.monotonic) -> None:
        topics = Topics(publish={options.request_topic: KIND}, subscribe={options.reply_topic: KIND})
        self._node = Ros2Link(options, "diverter", topics)
        address = f"{self._node.address}{options.reply_topic}"
        self._options, self._starting = options, Lock()
        super().__init__(self._connected, address, options.answer_timeout, clock)

    def connect(self) -> None:
        """Start the node, which may take longer than a command waits for it, and look for the controller.

        Raises
        ------
        CommandError
            `NOT_DONE` if the node does not start, or does not find the controller.
        """
        self._node.connect()
        super().connect()

    def close(self) -> None:
        """End the node; the next call starts it again."""
        super().close()
        self._node.close()

    def _connected(self, seconds: float) -> DiversionTopics:
        """Return a connection; a node that starts more slowly is started all the same, for the next call."""
        deadline = Deadline(IN_TIME * seconds)
        if not self._starting.acquire(timeout=deadline.left()):
            raise LinkError("beltsort's node is still being started; try again, or call connect() first")
        try:
            self._node.connect()
        finally:
            self._starting.release()
        return DiversionTopics(self._node, self._options, deadline)

    def __enter__(self) -> Self:
        """Use the device as a context that ends its node."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the node."""
        self.close()
