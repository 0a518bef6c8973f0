"""What is particular to a belt that never stops on ROS 2: its node, and those that come later."""

import os
import re
import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell import CommandError, Diversion, Outcome
from beltsort.drivers.ros2 import Ros2Diverter, Ros2DiverterOptions
from tests.cellfile.test_diverter import belt_of
from tests.drivers.ros2.diverter_rig import BEHIND_RELAY, DiverterRig
from tests.waiting import PATIENCE, alive, wait_until

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DiverterRig]:
    rig = DiverterRig(tmp_path_factory.mktemp("diverter"))
    yield rig
    rig.close()


@pytest.fixture
def device(shared: DiverterRig) -> Iterator[Ros2Diverter]:
    """Return a device of each test's own: the requests of one are out of date once another has asked."""
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


def test_a_controller_that_was_restarted_answers_the_next_call(
    shared: DiverterRig, device: Ros2Diverter
) -> None:
    before = device.reading()
    shared.controller.kill()
    shared.start()
    after = device.reading(timeout=PATIENCE)
    assert (before.boot_id == shared.boot_id, after.boot_id) == (False, shared.boot_id)


def test_a_cell_file_has_it_as_its_belt(shared: DiverterRig, tmp_path: Path) -> None:
    options = shared.options()
    given = f'options = {{python = "{options.python}", domain_id = {options.domain_id}}}'
    belt, device = belt_of(tmp_path, "ros2", given)
    assert isinstance(device, Ros2Diverter)
    with device:
        device.connect()
        reading = belt.reading()
        far = reading.travel + 100.0
        status = belt.divert("from a file", number=9, coordinate=far, label=2, boot_id=reading.boot_id)
        assert (status.state, status.boot_id) == (Diversion.QUEUED, shared.boot_id)


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
    assert rig.controller.announced["reply_topic"] == Ros2DiverterOptions.reply_topic
    assert re.fullmatch("[0-9a-f]{8,}", rig.boot_id)
    assert rig.controller.left_alone() == 0
    rig.close()
