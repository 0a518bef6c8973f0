"""`beltsort viewpoints`, run as a user runs it."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from beltsort.cli import main
from beltsort.viewpoints import Sampling, ViewpointMap, map_viewpoints

from ..cli.running import command, json_of
from .gantry import TIP, gantry

pytestmark = pytest.mark.process

PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "viewpoints.json"


def test_the_file_says_the_same_as_the_library(path: Path) -> None:
    result = json_of(
        *("viewpoints", str(path), "--method", "uniform", "--count", "50", "--seed", "3"),
        *("--radius", "0.6", "--lowest", "20", "--viewpoints", "4"),
    )
    expected = map_viewpoints(Sampling("uniform", 50, 0.6, 3), 4, lowest=20.0)
    read = ViewpointMap.load(result["file"])
    assert read.viewpoints == expected.viewpoints
    assert result["motion_cost"] == read.motion_cost.tolist() == expected.motion_cost.tolist()
    assert result["travel"] == expected.travel
    assert (result["reachable"], result["edges"]) == (expected.reachable.sum(), len(expected.edges))
    assert [v["point"] for v in result["viewpoints"]] == list(expected.chosen)
    assert Path(result["picture"]) == path.with_suffix(".png")
    assert Path(result["picture"]).read_bytes().startswith(PNG)


def test_in_words(path: Path) -> None:
    done = command("viewpoints", str(path), "--points", "50,80,51")
    assert done.stderr == f"written: {path}, {path.with_suffix('.png')}\n"
    assert done.stdout.startswith("100 points at 0.7 m, 74 reachable, ")
    assert re.search(r"^  viewpoint +point +azimuth +elevation +to p1 +to p2 +to p3\n", done.stdout, re.M)
    assert re.search(r"^  p2 +80 +-?[\d.]+° +53.6° +\d +1 +\d$", done.stdout, re.M)


def test_neighbours_only(path: Path) -> None:
    every = [str(i) for i in range(3, 12)]
    travel = json_of(
        *("viewpoints", str(path), "--count", "12", "--points", ",".join(every), "--neighbours-only")
    )["travel"]
    assert all(k in reached for k, reached in enumerate(travel))
    assert min(len(reached) for reached in travel) < len(travel)
    assert ViewpointMap.load(path).neighbours_only


def test_the_reach_of_a_urdf(path: Path, tmp_path: Path) -> None:
    arguments = ("viewpoints", str(path), "--urdf", str(gantry(tmp_path)), "--tip", TIP)
    result = json_of(*arguments, "--base=-0.3,0,0.3,0", "--viewpoints", "2")
    views = ViewpointMap.load(path)
    assert result["reachable"] == views.reachable.sum()
    assert views.points[views.reachable, 0].max() < 0.1
    assert views.note == f"gantry_revolute.urdf, camera at {TIP}, base at -0.3, 0, 0.3 m, yaw 0"


def test_the_reach_of_a_robot_is_remembered(path: Path) -> None:
    arguments = ("viewpoints", str(path), "--count", "40", "--robot", "panda", "--base=-0.4,0,0,0")
    first = json_of(*arguments)
    assert 5 < first["reachable"] < 30
    assert [file.name for file in path.parent.glob("cache/**/*.sqlite")] == ["reach.sqlite"]
    assert json_of(*arguments) == first


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["v.txt"], r"v\.txt\b.*\.json\b"),
        (["v.json", "--count", "0"], r"\bcount\b.*\b0\b"),
        (["v.json", "--points", "1;2"], r"--points 1;2\b.*\b3,17\b"),
        (["v.json", "--points", "2"], r"point 2\b.*\b26, 27, "),
        (["v.json", "--lowest", "90"], r"\b100 points\b.*\b90\.0 degrees"),
        (["v.json", "--tip", "tool0"], r"--tip\b.*--robot\b.*--urdf\b"),
        (["v.json", "--base", "0,0,0,0"], r"--base\b.*--robot\b.*--urdf\b"),
        (
            ["v.json", "--robot", "ur5"],
            r"robot\b.*--base\b.*--base=-0\.4,0,0,0",
        ),
        (
            ["v.json", "--robot", "ur5", "--base", "1,2,3"],
            r"--base 1,2,3\b.*\bX,Y,Z,YAW\b.*--base=-0\.4,0,0,0",
        ),
        (["v.json", "--urdf", "arm.urdf", "--base", "0,0,0,0"], r"--urdf\b.*--tip\b"),
        (["absent/v.json"], r"No such file.*absent/v\.json"),
    ],
)
def test_errors_are_one_line(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["viewpoints", *arguments, "--json"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("beltsort: error: ")
    assert re.search(message, captured.err)
    assert captured.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_without_the_extra_nothing_of_it_is_loaded() -> None:
    script = (
        "import sys, beltsort, beltsort.cli, beltsort.viewpoints\n"
        "print(sorted({'open3d', 'matplotlib', 'pinocchio'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_without_pinocchio_the_error_names_the_extra(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    arguments = ["viewpoints", str(path), "--urdf", str(gantry(tmp_path)), "--tip", TIP, "--base", "0,0,0,0"]
    assert main(arguments) == 2
    assert "pip install 'beltsort[ik]'" in capsys.readouterr().err


def test_the_file_is_json_with_one_line_per_key(path: Path) -> None:
    json_of("viewpoints", str(path))
    assert len(path.read_text().splitlines()) == len(json.loads(path.read_text())) + 2
