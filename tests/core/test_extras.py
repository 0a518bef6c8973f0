"""Without the packages of the extras planning works, and everything else names the extra that it needs."""

import json
import shutil
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

import pytest

import beltsort
from beltsort import BeltsortError
from beltsort.errors import MissingExtraError
from beltsort.sorting.entries import Started
from beltsort.sorting.journal import Journal
from beltsort.util.extras import extra, require

MISSING = (
    *("asyncua", "cryptography", "distributed", "matplotlib", "open3d", "PIL", "pinocchio", "pyarrow"),
    *("pydantic", "pydantic_core", "pymodbus", "rosbags", "scipy"),
)
PLANNING = (
    "info",
    "example opcua",
    "plan paper --trials 10 --explain",
    "plan paper --observe p3=mushroom,standard --trials 10 --json",
    "evaluate paper --policy threshold --threshold 0.9 --batches 10",
    "compare paper --policies one-object despot:5 --batches 4",
    "solve paper --positions 1 --seconds 0.5 -o one.solution",
    "plan paper --positions 1 --solution one.solution --trials 10",
    "compare paper --positions 1 --policies one-object threshold:0.9 --batches 4 --reference one.solution",
    "export paper paper.pomdp",
)
NEEDS = {
    "demo": "cell",
    "run cell.toml": "cell",
    "check cell.toml": "cell",
    "home cell.toml 1": "cell",
    "show journal.sqlite": "cell",
    "viewpoints views.json": "cell",
    "calibrate-belt scans.jsonl": "cell",
    "calibrate-check": "cell",
    "reproduce --quick": "cell",
    "sweep grid.toml": "sweep",
    "train clouds -o new.npz": "perception",
    "train clouds -o new.npz --figure confusion.png": "plot",
    "estimate simulated -o model.json": "perception",
    "classify database.npz clouds/bulb/cloud.csv": "perception",
    "prepare -o folder --objects-per-row 1 --training-objects 1": "perception",
}
PROGRAMS = {
    "beltsort.drivers.fieldbus.pki": "opcua",
    "beltsort.testing.opcua_server": "opcua",
    "beltsort.testing.modbus_server": "modbus",
}

RUN = f"""
import contextlib, io, json, sys
for module in {MISSING}:
    sys.modules[module] = None
from beltsort.cli import main
for command in json.load(sys.stdin):
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        try:
            code = main(command.split())
        except SystemExit as leaving:
            code = leaving.code
    print(json.dumps([command, code, out.getvalue(), err.getvalue()]))
"""


class Done(NamedTuple):
    command: str
    code: int
    out: str
    err: str


def run_without(folder: Path, *commands: str) -> list[Done]:
    """Run commands in a process that has none of the packages of the extras."""
    given = json.dumps(commands)
    done = subprocess.run(
        [sys.executable, "-c", RUN], input=given, cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return [Done(*json.loads(line)) for line in done.stdout.splitlines()]


@pytest.mark.process
def test_planning_needs_no_extra(tmp_path: Path) -> None:
    for done in run_without(tmp_path, *PLANNING):
        assert done.code == 0, done
        assert done.out, done


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with what the commands name, as far as they look at it before they miss a package."""
    clouds = tmp_path / "clouds" / "bulb"
    clouds.mkdir(parents=True)
    shutil.copy(Path(__file__).parents[1] / "cases" / "clouds" / "cloud.csv", clouds)
    packaged = files("beltsort.models") / "simulated_cell" / "classifier.npz"
    (tmp_path / "database.npz").write_bytes(packaged.read_bytes())
    with Journal(tmp_path / "journal.sqlite") as journal:
        journal.append(Started(run="r", objects=1, model=beltsort.models.paper().to_json()))
    return tmp_path


@pytest.mark.process
def test_each_other_command_names_its_extra(folder: Path) -> None:
    for done in run_without(folder, *NEEDS):
        assert done.code == 2, done
        assert done.err.endswith(f" is not installed; pip install 'beltsort[{NEEDS[done.command]}]'\n"), done
        assert "Traceback" not in done.err


@pytest.mark.process
@pytest.mark.parametrize("module", PROGRAMS)
def test_each_program_names_its_extra(module: str) -> None:
    script = (
        f"import runpy, sys\nfor module in {MISSING}: sys.modules[module] = None\n"
        f"runpy.run_module({module!r}, run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert f"pip install 'beltsort[{PROGRAMS[module]}]'" in done.stderr
    assert "Traceback" not in done.stderr


def test_the_outermost_block_names_the_extra() -> None:
    with (
        pytest.raises(MissingExtraError, match=r"^no_such_package is .* 'beltsort\[sweep\]'$"),
        extra("sweep"),
        extra("cell"),
    ):
        __import__("no_such_package")


def test_a_library_that_cannot_be_loaded_is_told() -> None:
    with (
        pytest.raises(MissingExtraError, match=r"libX11\.so\.6: cannot open .*\bperception\b"),
        extra("perception"),
    ):
        raise ImportError("libX11.so.6: cannot open shared object file", name="open3d.cpu.pybind")


def test_the_error_is_one_of_ours_and_of_pythons() -> None:
    with pytest.raises(MissingExtraError) as raised:
        require("plot", "json", "no_such_package")
    assert isinstance(raised.value, BeltsortError)
    assert isinstance(raised.value, ImportError)
