"""What a device on ROS logs: its own nodes, the other ones, and outcomes that are unknown."""

import logging
import os
import signal
from collections.abc import Iterator

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros2 import Ros2Belt
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig
from tests.waiting import alive, wait_until

pytestmark = pytest.mark.process


class Told:
    """The messages that were logged since the last look."""

    def __init__(self, caplog: pytest.LogCaptureFixture) -> None:
        self._caplog = caplog

    def new(self) -> list[str]:
        """Return level and message of each record of the drivers, and forget them."""
        found = [
            f"{record.levelname} {record.getMessage()}"
            for record in self._caplog.records
            if record.name.startswith("beltsort.drivers.ros.")
        ]
        self._caplog.clear()
        return found


@pytest.fixture
def told(caplog: pytest.LogCaptureFixture) -> Iterator[Told]:
    with caplog.at_level(logging.INFO, "beltsort"):
        yield Told(caplog)


def only(found: list[str], *beginnings: str) -> list[str]:
    """Return the records, which must begin so, in this order."""
    assert len(found) == len(beginnings), found
    assert all(record.startswith(begins) for record, begins in zip(found, beginnings, strict=True)), found
    return found


def test_nodes_that_start_are_lost_and_end(rig: Rig, told: Told) -> None:
    with Ros2Belt(scene.belt(rig.domain)) as belt:
        wait_until(lambda: belt.health().ready, "the belt is ready")
        assert belt.health().ready
        started, *_, ready = told.new()
        assert started.startswith("INFO started the ROS node beltsort_belt_")
        assert ready == f"INFO {belt.address} is ready"
        own = int(started.rpartition(" ")[2])
        os.kill(own, signal.SIGKILL)
        wait_until(lambda: not alive(own), "our node ends")
        belt.connect()
        only(
            told.new(),
            "WARNING lost the ROS node beltsort_belt_",
            "INFO ended the ROS node beltsort_belt_",
            "INFO started the ROS node beltsort_belt_",
        )
    only(told.new(), "INFO ended the ROS node beltsort_belt_")


def test_another_node_that_is_lost_and_restarted(rig: Rig, belt: Ros2Belt, told: Told) -> None:
    wait_until(lambda: belt.health().ready, "the belt is ready")
    told.new()
    rig.kill(rig.peer)
    for _ in range(2):
        assert not belt.health().ready
    only(told.new(), f"WARNING {belt.address} is not ready: ")
    rig.start_peer()
    wait_until(lambda: belt.health().ready, "the belt is ready again")
    assert belt.health().ready
    assert told.new()[-1:] == [f"WARNING {belt.address} was restarted"]


def test_an_outcome_that_is_unknown(rig: Rig, belt: Ros2Belt, told: Told) -> None:
    wait_until(lambda: belt.health().ready, "the belt is ready")
    at = rig.tell(stuck=True)["object"]
    told.new()
    with pytest.raises(CommandError) as error:
        belt.advance_to(at + 1, "one of a log", timeout=2.0)
    assert error.value.outcome is Outcome.UNKNOWN
    only(
        told.new(),
        f"WARNING the outcome of one of a log, advance_to({at + 1}), is unknown: the belt reported ",
    )
