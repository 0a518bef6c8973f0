"""The connection to a controller of diversions on ROS 2, without a process."""

from dataclasses import replace
from threading import Event
from typing import Any

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.fieldbus.diversions import DiversionRequest, DiversionVerb
from beltsort.drivers.fieldbus.link import LinkError
from beltsort.drivers.fieldbus.wire import GarbageError, boot_id_of
from beltsort.drivers.ros.link import Outgoing, Topics
from beltsort.drivers.ros.process import Answer
from beltsort.drivers.ros2 import Ros2Diverter, Ros2DiverterOptions
from beltsort.drivers.ros2.diversion_messages import KIND, decode_request, encode_reply
from beltsort.drivers.ros2.diverter import DiversionTopics
from beltsort.drivers.ros2.link import Ros2Link
from beltsort.drivers.ros2.node import KEPT
from beltsort.testing.diverting import DivertingController, DivertingMachine
from tests.waiting import PATIENCE

OPTIONS = Ros2DiverterOptions()


class Told(Ros2Link):
    """A node whose messages a controller answers, without a process."""

    def __init__(self) -> None:
        super().__init__(OPTIONS, "diverter", Topics())
        self.controller = DivertingController(DivertingMachine(), boot=5, clock=lambda: 0.0)
        self.messages: list[list[int]] = []
        self.listening = True
        self.deaf, self.heard = 0, 0

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
            self.heard += 1
            if self.heard <= self.deaf or not self.controller.is_new(request):
                return True
            self.messages.append(encode_reply(self.controller.answer(request)))
        return self.listening


def look(sequence: int) -> DiversionRequest:
    return DiversionRequest(sequence, DiversionVerb.LOOK)


def test_who_comes_later_gets_the_last_reply_and_then_the_next() -> None:
    node = Told()
    node.controller.sequence = 7
    node.messages.append(encode_reply(node.controller.look()))
    topics = DiversionTopics(node, OPTIONS, Deadline(0.1))
    assert topics.read().sequence == topics.read().sequence == 7
    topics.write(look(8))
    assert topics.read().sequence == 8
    topics.close()


def test_without_any_reply_there_is_no_connection() -> None:
    with pytest.raises(LinkError, match=r"\bno reply on /diverter/reply\b.*\bof the controller; start it\b"):
        DiversionTopics(Told(), OPTIONS, Deadline(0.01))


def test_a_message_that_is_no_reply_stays_garbage_until_the_next() -> None:
    node = Told()
    node.messages.append([1, 2, 3])
    topics = DiversionTopics(node, OPTIONS, Deadline(0.1))
    for _ in range(2):
        with pytest.raises(GarbageError, match=r"\blength is 3\b"):
            topics.read()
    topics.write(look(4))
    assert topics.read().sequence == 4


def test_a_request_that_nobody_hears_is_an_error() -> None:
    node = Told()
    node.listening = False
    node.messages.append(encode_reply(node.controller.look()))
    topics = DiversionTopics(node, replace(OPTIONS, answer_timeout=0.01), Deadline(0.1))
    with pytest.raises(CommandError, match=r"/diverter/request has no subscriber\b"):
        topics.write(look(1))


def test_a_request_that_was_lost_is_repeated_and_executed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("beltsort.drivers.ros2.diverter.REPEAT", 0.0)
    node = Told()
    node.messages.append(encode_reply(node.controller.look()))
    topics = DiversionTopics(node, OPTIONS, Deadline(0.1))
    assert topics.read().sequence == 0
    node.deaf = 2
    topics.write(look(1))
    assert [topics.read().sequence for _ in range(3)] == [0, 0, 1]
    for _ in range(3):
        topics.read()
    assert len(node.messages) == 2
    assert node.heard > node.deaf + 1, "the controller has heard it again, and not answered"


def test_a_node_that_starts_slowly_is_started_once() -> None:
    started = Event()
    starts: list[float] = []

    class Slow(Told):
        def connect(self, timeout: float = 0.0) -> None:
            starts.append(timeout)
            assert started.wait(PATIENCE)

    device = Ros2Diverter(OPTIONS)
    device._node = node = Slow()
    node.messages.append(encode_reply(node.controller.look()))
    for said in (r"\bconnecting did not end\b", r"\bstill being started\b"):
        with pytest.raises(CommandError, match=said) as error:
            device.reading(timeout=0.1)
        assert error.value.outcome is Outcome.NOT_DONE
    assert len(starts) == 1
    started.set()
    assert device.reading(timeout=PATIENCE).boot_id == boot_id_of(node.controller.look().boot)


def test_the_type_of_the_messages_is_kept_for_those_that_come_later() -> None:
    assert KIND in KEPT
