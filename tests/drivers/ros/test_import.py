"""The protocols, and what is wired but not used, bring no driver along."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.process

SCRIPT = """
import sys, beltsort, beltsort.cell, beltsort.drivers.replay, beltsort.drivers.ros1
print(*sorted({"rosbags", "rospy", "genpy", "open3d"} & set(sys.modules)))
"""


def test_import() -> None:
    run = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert run.stdout == "\n"
