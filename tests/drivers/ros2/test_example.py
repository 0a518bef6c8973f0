"""The example of docs/ros.md sorts objects over ROS 2, and the page's cell file is valid."""

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from beltsort.cellfile.composed import compose
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.roles import ROLES
from beltsort.sim import CellConfig
from beltsort.sim.prepare import prepare
from tests.docs.pages import ROOT, PageRun, blocks_of
from tests.drivers.ros2.rig import HeldDomain, require_ros2
from tests.drivers.ros2.scene import PYTHON
from tests.waiting import PATIENCE, wait_until

pytestmark = [pytest.mark.process, pytest.mark.slow]

PAGE = ROOT / "docs" / "ros.md"
BY_TEST = "by the test of the example"
OBJECTS = 4
"""As many as the page's comment for tests says."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a copy of the example with classifier and tables, in a domain of its own."""
    require_ros2()
    cell = tmp_path / "cell"
    shutil.copytree(ROOT / "examples" / "ros2", cell)
    (cell / "ros2").symlink_to(Path(PYTHON).parents[1])
    prepared, config = prepare(), CellConfig()
    prepared.database.save(cell / "model.classifier.npz")
    names = [viewpoint.name for viewpoint in config.viewpoints]
    prepared.counts.model(config.classes, names).save(cell / "model.json")
    held = HeldDomain()
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("ROS_DOMAIN_ID", str(held.number))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    yield cell
    held.close()


def test_the_example(folder: Path) -> None:
    started, sorted_by = (block for block in blocks_of(PAGE) if block.comments.get("not run") == BY_TEST)
    log = folder / "node.log"
    with log.open("w") as output:
        node = subprocess.Popen(
            [*started.code.split(), "--renderer-python", sys.executable],
            cwd=folder,
            stdout=output,
            stderr=subprocess.STDOUT,
        )
        try:
            wait_until(lambda: "are ready" in log.read_text() or node.poll() is not None, "the node is ready")
            assert node.poll() is None, log.read_text()
            run = PageRun(PAGE, folder)
            run.shell(sorted_by)
        finally:
            node.send_signal(signal.SIGINT)
            assert node.wait(PATIENCE) == 0, log.read_text()
    assert "everything is within the limits" in run.printed
    assert f"{OBJECTS} sorted in " in run.printed
    told = re.findall(r'object +(\d+) +into bin "\w+" \((\d)\)', run.printed)
    done = re.findall(r"object (\d+) \((?!None)\w+\) into bin (\d)", log.read_text())
    assert told == done
    assert [int(number) for number, _ in done] == list(range(OBJECTS))


def test_the_cell_file_of_the_page_describes_four_devices(tmp_path: Path) -> None:
    example = (ROOT / "examples" / "ros2" / "cell.toml").read_text()
    shown = next(block.code for block in blocks_of(PAGE) if "[arm.options.taught]" in block.code)
    head, viewpoints = example.partition("[backends.ros2]")[0], ("p1", "p2")
    assert '[[viewpoints]]\nname = "p3"' in head
    path = tmp_path / "cell.toml"
    path.write_text(head.partition('[[viewpoints]]\nname = "p3"')[0] + shown)
    description = CellDescription.load(path)
    assert description.viewpoint_names == viewpoints
    assert {description.device(role).backend for role in ROLES} == {"ros2"}
    assert compose(description, live=True, say=print).viewpoints == viewpoints


def test_without_a_renderer_the_node_says_what_is_missing(folder: Path) -> None:
    done = subprocess.run(
        ["ros2/bin/python", "cell_node.py", "--renderer-python", "ros2/bin/python", "--cell", "cell.toml"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": ""},
        capture_output=True,
        text=True,
    )
    assert done.returncode != 0
    assert "--renderer-python" in done.stderr
