"""`import beltsort` brings no heavy package along; how long it takes is in benchmarks/test_import.py."""

import subprocess
import sys

import pytest

from tests.cli.running import PAPER

pytestmark = pytest.mark.process

SCRIPT = """
import sys
import beltsort
heavy = {"open3d", "matplotlib", "rich", "sklearn", "pydantic", "pyarrow", "distributed"}
print(*sorted(heavy & set(sys.modules)))
"""


def test_import() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


PLANS_WITHOUT = f"""
import sys
for module in ("open3d", "matplotlib", "rich", "scipy", "pydantic", "filelock", "platformdirs", "PIL"):
    sys.modules[module] = None
from beltsort.cli import main
sys.exit(main(["plan", {PAPER!r}, "--trials", "10"]))
"""


def test_planning_from_the_command_line_needs_numpy_alone() -> None:
    done = subprocess.run([sys.executable, "-c", PLANS_WITHOUT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "move to" in done.stdout
