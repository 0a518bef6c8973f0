"""A run as a node of ROS 2, and another node that looks at it."""

import json
import os
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell import within
from beltsort.models import paper
from beltsort.ros2.markers import Scene
from beltsort.ros2.options import NodeOptions
from beltsort.ros2.run_node import QUEUED, Parameter, RunDescription, RunNode
from beltsort.sorting.entries import Ended
from beltsort.sorting.journal import Entry
from beltsort.sorting.report import SortingReport
from beltsort.sorting.requests import Request, read_request, taking_requests, write_request
from beltsort.sorting.runs import sort_into
from tests.drivers.ros2.rig import HeldDomain, require_ros2
from tests.drivers.ros2.scene import PYTHON
from tests.monitoring.runs import run_of
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted
from tests.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.process

PEER = Path(__file__).with_name("peer.py")
OBJECTS = 400


class Looker:
    """The other node."""

    def __init__(self, domain: int, directory: Path) -> None:
        ros = {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(directory),
        }
        self.process = subprocess.Popen(
            [PYTHON, str(PEER)],
            env={**os.environ, **ros},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._line() == "ready\n"

    def tell(self, **what: str) -> dict[str, Any]:
        """Tell the node to do something; return what it answers."""
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(what) + "\n")
        self.process.stdin.flush()
        answer: dict[str, Any] = json.loads(self._line())
        return answer

    def latest(self, topic: str) -> dict[str, str]:
        """Return the values of the latest message."""
        for message in reversed(self.tell()[topic]):
            return {pair["key"]: pair["value"] for pair in message["status"][0]["values"]}
        return {}

    def lifecycle(self) -> str:
        """Return the state of the run's node."""
        return str(self.tell(ask="state")["lifecycle"])

    def _line(self) -> str:
        assert self.process.stdout is not None
        return str(within(PATIENCE, "the other node's answer", self.process.stdout.readline))


@pytest.fixture(scope="module")
def domain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    require_ros2()
    held = HeldDomain()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_LOG_DIR", str(tmp_path_factory.mktemp("ros2")))
        yield held.number
    held.close()


@pytest.fixture
def looker(domain: int, tmp_path: Path) -> Iterator[Looker]:
    found = Looker(domain, tmp_path)
    yield found
    found.process.kill()
    found.process.wait()


def described(folder: Path) -> RunDescription:
    model = paper()
    parameters: dict[str, Parameter] = {"classes": list(model.classes)}
    return RunDescription(folder, parameters, Scene.of(ScriptedCell(model)), model.labels)


def node_of(domain: int, folder: Path, said: list[str]) -> RunNode:
    return RunNode(NodeOptions(python=PYTHON, domain_id=domain), described(folder), said.append)


class SlowRun(AbstractContextManager["SlowRun"]):
    """A run of many objects in a thread, which takes requests; it is stopped at the end."""

    def __init__(self, folder: Path, node: RunNode) -> None:
        self.folder, self.node, self.cell = folder, node, ScriptedCell(paper())
        self.report: SortingReport | None = None
        self.stopping = False
        self.thread = threading.Thread(target=self.sort)

    def sort(self) -> None:
        def check() -> None:
            time.sleep(0.01)
            if self.stopping:
                raise KeyboardInterrupt

        sorted_with = (self.folder, self.cell, scripted([[2, 3]] * OBJECTS), LookOnce(), paper())
        with taking_requests(self.folder):
            try:
                self.report = sort_into(
                    *sorted_with,
                    objects=OBJECTS,
                    listener=self.node,
                    check=check,
                    requests=self.folder,
                    scan_listener=self.node.scanned,
                )
            except KeyboardInterrupt:
                return

    def __enter__(self) -> "SlowRun":
        self.thread.start()
        return self

    def __exit__(self, *_failure: object) -> None:
        self.stopping = True
        self.thread.join(PATIENCE)

    def stands(self) -> bool:
        acts = len(self.cell.acts)
        time.sleep(0.3)
        return len(self.cell.acts) == acts

    def goes_on(self) -> bool:
        return not self.stands()


def test_a_run_is_published_also_for_those_that_come_later(
    domain: int, looker: Looker, tmp_path: Path
) -> None:
    said: list[str] = []
    with node_of(domain, tmp_path, said) as node:
        run_of(tmp_path, node)
        wait_until(lambda: looker.latest("state").get("state") == "Complete", "the run is complete")
        wait_until(lambda: len(looker.tell()["decision"]) == 3, "three decisions arrive")
        found = looker.tell()
        names = [message["status"][0]["name"] for message in found["decision"]]
        assert names == ["beltsort: object 0", "beltsort: object 2", "beltsort: object 3"]
        assert [pair["size"] for pair in found["belief"][-1]["layout"]["dim"]] == [2, 4]
        assert sum(found["belief"][-1]["data"]) == pytest.approx(2.0)
        assert looker.latest("state")["empty"] == "1"
        kinds = [marker["ns"] for marker in found["markers"][-1]["markers"]]
        assert kinds == ["belt", "positions", "positions"]  # no scan is given, and no pose is known
        told = looker.tell(parameter="classes")
        assert told["value"] == list(paper().classes)
        assert not told["success"]
        assert not looker.tell(transition="deactivate")["success"]  # the run takes no requests
        assert looker.lifecycle() == "active"
    assert said == []


def test_deactivate_holds_and_activate_continues(domain: int, looker: Looker, tmp_path: Path) -> None:
    said: list[str] = []
    with node_of(domain, tmp_path, said) as node, SlowRun(tmp_path, node) as run:
        wait_until(lambda: looker.lifecycle() == "active", "the node is active")
        assert looker.tell(transition="deactivate")["success"]
        wait_until(lambda: looker.latest("state").get("state") == "Held", "the run is held")
        assert looker.tell()["state"][-1]["level"] == 1
        assert run.stands()
        shown = {marker["ns"] for marker in looker.tell()["markers"][-1]["markers"]}
        assert {"candidates", "labels"} <= shown
        request = read_request(tmp_path)
        assert request is not None
        assert "ROS 2 node beltsort" in request.by
        assert looker.tell(transition="activate")["success"]
        wait_until(run.goes_on, "the run goes on")
        write_request(tmp_path, Request.now("hold", "the test"))  # another hold makes the node inactive
        wait_until(lambda: looker.lifecycle() == "inactive", "the node is inactive")
        write_request(tmp_path, Request.now("continue", "the test"))
        wait_until(lambda: looker.lifecycle() == "active", "the node is active again")
        wait_until(run.goes_on, "the run goes on again")
    assert said == []


def test_a_killed_node_ends_no_run(domain: int, tmp_path: Path) -> None:
    said: list[str] = []
    with node_of(domain, tmp_path, said) as node, SlowRun(tmp_path, node) as run:
        wait_until(lambda: node.process_id, "the node runs")
        os.kill(node.process_id or 0, 9)
        wait_until(lambda: said, "the end of the node is told")
        assert run.goes_on()
    assert len(said) == 1
    assert "no longer published on ROS 2" in said[0]


def test_a_node_that_does_not_start_is_told_once(tmp_path: Path) -> None:
    said: list[str] = []
    options = NodeOptions(python=str(tmp_path / "none"))
    with RunNode(options, described(tmp_path), said.append) as node:
        wait_until(lambda: said, "it is told")
        assert len(run_of(tmp_path, node).decisions) == 3
    assert len(said) == 1
    assert "none" in said[0]


def test_a_node_that_falls_behind_is_given_up(tmp_path: Path) -> None:
    said: list[str] = []
    node = RunNode(NodeOptions(), described(tmp_path), said.append)
    for number in range(QUEUED + 10):
        node(Entry(number, "2026-01-01T00:00:00+00:00", None, Ended("done")))
    assert len(said) == 1
    assert f"{QUEUED} entries" in said[0]
