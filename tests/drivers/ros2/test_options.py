"""Options that do not fit are refused before anything starts; what needs no ROS is tried without."""

import dataclasses
from typing import Any

import pytest

from beltsort.cell import Outcome
from beltsort.drivers.ros2 import Ros2BeltOptions, Ros2DiverterOptions
from beltsort.drivers.ros2.node import Discovered, gid_of
from beltsort.drivers.ros2.status import statuses
from beltsort.errors import CellError
from tests.drivers.ros2 import scene

pytestmark = pytest.mark.process


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"domain_id": 233}, r"\bdomain_id is 233\b.*\b0 to 232\b"),
        ({"domain_id": -1}, r"\bdomain_id is -1\b"),
        ({"discovery_range": "EVERYWHERE"}, r"\bdiscovery_range is 'EVERYWHERE'.*\bLOCALHOST\b.*\bSUBNET\b"),
    ],
)
def test_a_system_that_does_not_exist(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        Ros2BeltOptions(**changes)
    for options in (scene.sorter(1), scene.camera_by_tf(1), scene.arm(1)):
        with pytest.raises(CellError, match=said):
            dataclasses.replace(options, **changes)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"domain_id": 233}, r"\bdomain_id is 233\b"),
        ({"request_topic": "/belt", "reply_topic": "/belt"}, r"\bis '/belt' and reply_topic '/belt'"),
        ({"reply_topic": ""}, r"\breply_topic '', expected two different\b"),
        ({"answer_timeout": 0.0}, r"\banswer_timeout is 0\.0\b"),
    ],
)
def test_a_controller_of_diversions_that_cannot_be(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        Ros2DiverterOptions(**changes)


def test_the_states_of_keys() -> None:
    def entry(name: str, state: str) -> dict[str, Any]:
        return {"name": name, "message": "why", "values": [{"key": "state", "value": state}]}

    states = ("active", "succeeded", "rejected", "aborted", "something new")
    found = statuses({"status": [entry(state, state) for state in states]})
    outcomes = [Outcome.RUNNING, Outcome.DONE, Outcome.NOT_DONE, Outcome.BROKEN_OFF, Outcome.UNKNOWN]
    assert [found[state].outcome for state in states] == outcomes
    assert statuses({"status": [{"name": "bare", "message": "", "values": []}]})["bare"].name == ""


def test_the_sender_of_a_message_that_does_not_name_it_is_the_last_one_discovered() -> None:
    assert gid_of({}) == gid_of({"publisher_gid": None}) == ""
    assert gid_of({"publisher_gid": {"data": b"\x01\x0f"}}) == "010f"
    discovered = Discovered()
    assert discovered.last("/a", ["killed"]) == "killed"
    assert discovered.last("/a", ["restarted", "killed"]) == "restarted"
    assert discovered.last("/b", ["killed"]) == "killed"
    assert discovered.last("/a", ["restarted"]) == "restarted"
