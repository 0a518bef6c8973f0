"""Options that are paths start at the folder of the cell file."""

from pathlib import Path

import pytest

from beltsort.cellfile.paths import resolved
from beltsort.drivers.opcua import OpcuaOptions
from beltsort.drivers.ros2 import Ros2BeltOptions
from tests.cellfile.cell_files import described


def test_files_and_programs_with_a_slash(tmp_path: Path) -> None:
    cell = described(tmp_path)
    found = resolved(Ros2BeltOptions(setup="workspace/setup.bash", python="ros2/bin/python"), cell)
    assert found.setup == str(tmp_path / "workspace" / "setup.bash")
    assert found.python == str(tmp_path / "ros2" / "bin" / "python")
    assert found.state_topic == "/belt/object"
    controller = OpcuaOptions(
        "opc.tcp://127.0.0.1:1", certificate="a.pem", private_key="b.pem", trust="trusted"
    )
    assert resolved(controller, cell).trust == str(tmp_path / "trusted")


@pytest.mark.parametrize("python", ["", "python3", "/opt/ros2/bin/python"])
def test_names_of_programs_and_absolute_paths_stay(python: str, tmp_path: Path) -> None:
    options = Ros2BeltOptions(python=python)
    assert resolved(options, described(tmp_path)) == options
