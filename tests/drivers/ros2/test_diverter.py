"""What is particular to a belt that never stops on ROS 2: its topics, its node, and those that come later."""

import os
import re
import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell import CommandError, Diversion, Outcome
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.fieldbus.diversions import DiversionRequest, DiversionVerb
from beltsort.drivers.fieldbus.link import LinkError
from beltsort.drivers.fieldbus.wire import GarbageError
from beltsort.drivers.ros.link import Outgoing, Topics
from beltsort.drivers.ros.process import Answer
from beltsort.drivers.ros2 import Ros2Diverter, Ros2DiverterOptions
from beltsort.drivers.ros2.diversion_messages import KIND, decode_request, encode_reply
from beltsort.drivers.ros2.diverter import DiversionTopics
from beltsort.drivers.ros2.link import Ros2Link
from beltsort.drivers.ros2.node import KEPT
from beltsort.testing.diverting import DivertingController, DivertingMachine
from tests.drivers.ros2.diverter_rig import BEHIND_RELAY, DiverterRig
from tests.waiting import alive, wait_until

pytestmark = pytest.mark.process

OPTIONS = Ros2DiverterOptions()


class Told(Ros2Link):
    """A node whose messages a controller answers, without a process."""

    def __init__(self) -> None:
        super().__init__(OPTIONS, "diverter", Topics())
        self.controller = DivertingController(DivertingMachine(), boot=5, clock=lambda: 0.0)
        self.messages: list[list[int]] = []
        self.listening = True

    def connect(self, timeout: float = 0.0) -> None:
        pass

    def newest(self, topic: str, deadline: Deadline, *, after: int = 0, **_wanted: float) -> Answer:
        assert topic == OPTIONS.reply_topic
        number = len(self.messages)
        message = {"data": self.messages[-1]} if number > after else None
        return Answer({"number": max(number, after), "message": message}, b"")

    def send_once(self, outgoing: Outgoing, deadline: Deadline) -> bool:
        if self.listening:
            assert outgoing.to == OPTIONS.request_topic
            message: Any = outgoing.arguments["message"]
            request = decode_request(message["data"])
            assert request is not None
            self.messages.append(encode_reply(self.controller.answer(request)))
        return self.listening


def look(sequence: int) -> DiversionRequest:
    return DiversionRequest(sequence, DiversionVerb.LOOK)


def test_who_comes_later_gets_the_last_reply_and_then_the_next() -> None:
    node = Told()
    node.controller.sequence = 7
    node.messages.append(encode_reply(node.controller.look()))
    topics = DiversionTopics(node, OPTIONS, 0.1)
    assert topics.read().sequence == topics.read().sequence == 7
    topics.write(look(8))
    assert topics.read().sequence == 8
    topics.close()


def test_without_any_reply_there_is_no_connection() -> None:
    with pytest.raises(LinkError, match=r"\bno reply on /diverter/reply\b.*\bof the controller; start it\b"):
        DiversionTopics(Told(), OPTIONS, 0.01)


def test_a_message_that_is_no_reply_stays_garbage_until_the_next() -> None:
    node = Told()
    node.messages.append([1, 2, 3])
    topics = DiversionTopics(node, OPTIONS, 0.1)
    for _ in range(2):
        with pytest.raises(GarbageError, match=r"\blength is 3\b"):
            topics.read()
    topics.write(look(4))
    assert topics.read().sequence == 4


def test_a_request_that_nobody_hears_is_an_error() -> None:
    node = Told()
    node.listening = False
    node.messages.append(encode_reply(node.controller.look()))
    topics = DiversionTopics(node, replace(OPTIONS, answer_timeout=0.01), 0.1)
    with pytest.raises(CommandError, match=r"/diverter/request has no subscriber\b"):
        topics.write(look(1))


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DiverterRig]:
    rig = DiverterRig(tmp_path_factory.mktemp("diverter"))
    yield rig
    rig.close()


@pytest.fixture(scope="module")
def device(shared: DiverterRig) -> Iterator[Ros2Diverter]:
    with shared.device() as device:
        device.connect()
        yield device


def test_another_node_goes_on_where_the_first_one_was(shared: DiverterRig, device: Ros2Diverter) -> None:
    reading = device.reading()
    order: dict[str, Any] = {
        "number": 1,
        "coordinate": reading.travel + 100.0,
        "label": 1,
        "boot_id": reading.boot_id,
    }
    assert reading.boot_id == shared.boot_id
    assert device.divert("later", **order).state is Diversion.QUEUED
    with shared.device() as later:
        later.connect()
        assert later.diversion("later", boot_id=reading.boot_id).state is Diversion.QUEUED
        assert later.divert("later", **order).state is Diversion.QUEUED
        assert later.reading().travel > reading.travel
    assert shared.controller.push("look")["queued"] == 1
    assert device.diversion("later", boot_id=reading.boot_id).state is Diversion.QUEUED


def test_a_node_that_was_killed_is_started_again(shared: DiverterRig, device: Ros2Diverter) -> None:
    process = device._node._process
    assert process is not None
    os.kill(process.process_id, signal.SIGKILL)
    wait_until(lambda: not alive(process.process_id), "our node ends")
    assert device.reading().boot_id == shared.boot_id
    assert device._node._process is not process


def test_a_device_that_was_closed_starts_its_node_again(shared: DiverterRig) -> None:
    with shared.device() as device:
        device.connect()
        device.close()
        assert device.health().ready


def test_nobody_on_these_topics_is_told(shared: DiverterRig) -> None:
    changes = {"request_topic": "/nobody/request", "reply_topic": "/nobody/reply"}
    with shared.device(**changes) as device:
        with pytest.raises(CommandError, match=r"no reply on /nobody/reply\b") as error:
            device.reading(timeout=8.0)
        assert error.value.outcome is Outcome.NOT_DONE


def test_an_installation_that_has_no_ros_is_told(shared: DiverterRig) -> None:
    with (
        shared.device(python=sys.executable) as device,
        pytest.raises(CommandError, match=r"\brclpy\b.*pip install 'ros-rclpy") as error,
    ):
        device.connect()
    assert error.value.outcome is Outcome.NOT_DONE


def test_a_request_that_is_late_after_the_question_never_acts(tmp_path: Path) -> None:
    with ExitStack() as stack:
        rig = DiverterRig(tmp_path, *BEHIND_RELAY)
        stack.callback(rig.close)
        relay = rig.relay()
        stack.callback(relay.kill)
        device = stack.enter_context(rig.device())
        device.connect()
        reading = device.reading()
        order: dict[str, Any] = {"number": 1, "coordinate": reading.travel + 100.0, "label": 1}
        order["boot_id"] = reading.boot_id
        relay.push("hold")
        with pytest.raises(CommandError) as error:
            device.divert("held back", **order, timeout=1.0)
        assert error.value.outcome is Outcome.UNKNOWN
        status = device.diversion("held back", boot_id=reading.boot_id)
        assert (status.state, status.retry) == (Diversion.NOT_DONE, True)
        relay.push("deliver")
        device.reading()  # behind it, and so it has arrived
        assert rig.controller.push("look")["queued"] == 0
        assert device.divert("held back", **order).state is Diversion.QUEUED
        assert rig.controller.push("look")["queued"] == 1


def test_the_reference_controller_ends_with_who_pushes_its_buttons(tmp_path: Path) -> None:
    rig = DiverterRig(tmp_path)
    assert rig.controller.announced["reply_topic"] == OPTIONS.reply_topic
    assert re.fullmatch("[0-9a-f]{8,}", rig.boot_id)
    assert rig.controller.left_alone() == 0
    rig.close()


def test_the_type_of_the_messages_is_kept_for_those_that_come_later() -> None:
    assert KIND in KEPT
