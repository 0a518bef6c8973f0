"""The benchmark of the machine at hand: what it says is whole and coherent; how fast is another matter."""

import json
import re
from contextlib import redirect_stdout
from io import StringIO
from typing import Any

import numpy as np
import pytest

from beltsort import Belief, Despot
from beltsort._core import BUILD_PROFILE
from beltsort.models import paper
from beltsort.perception import PerceptionConfig, describe, segment
from beltsort.sim import CellConfig, SimulatedCell
from benchmarks.machine import planning as bench
from benchmarks.machine.__main__ import main
from benchmarks.machine.stages import own_stages, plain_stages
from benchmarks.machine.stopwatch import Stopwatch
from tests.cli.running import PAPER

pytestmark = pytest.mark.slow


def output(*arguments: str) -> str:
    printed = StringIO()
    with redirect_stdout(printed):
        assert main(arguments) == 0
    return printed.getvalue()


def json_of(*arguments: str) -> dict[str, Any]:
    result = json.loads(output(*arguments, "--json"))
    assert isinstance(result, dict)
    return result


def test_bench_as_json() -> None:
    facts = json_of("--seconds", "0.2", "--model", PAPER)
    assert facts["processor"]
    assert facts["build_profile"] == BUILD_PROFILE
    assert facts["peak_memory"] > 2**20
    planner = Despot(paper(), scenarios=facts["scenarios"], trials=facts["trials"])
    plan = planner.plan(Belief(paper()))
    assert [row["threads"] for row in facts["throughput"]][-1] == facts["processors"]
    for row in facts["throughput"]:
        assert row["plans"] > 0
        assert row["expansions"] == pytest.approx(row["plans"] * plan.expansions)
        assert row["scenario_steps"] == pytest.approx(row["plans"] * plan.scenario_steps)
    assert facts["throughput"][0]["speed_up"] == 1.0
    assert facts["overshoot"]["plans"] >= 3
    assert facts["overshoot"]["p50"] <= facts["overshoot"]["p99"]


def test_bench_in_words() -> None:
    text = output("--seconds", "0.1")
    assert re.search(r"\d processors; (release|debug) build\n", text)
    assert re.search(
        r"^  threads +plans +expansions +scenario steps +speed-up\n  1 .* 1\.00\n", text, re.MULTILINE
    )
    assert "A deadline of 1 ms is missed by" in text
    assert re.search(r"Peak memory: \d+ MiB\n$", text)


def test_a_debug_build_is_told_loudly(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bench, "BUILD_PROFILE", "debug")
    assert main(["--seconds", "0.01"]) == 0
    captured = capsys.readouterr()
    assert re.match(r"WARNING: .*`make build`", captured.err)
    assert "debug build" in captured.out


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "inf"])
def test_a_time_must_be_above_zero(seconds: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([f"--seconds={seconds}"]) == 2
    assert re.search(rf"seconds\b.*{seconds}\b.*\b0\b", capsys.readouterr().err)


def test_thread_counts() -> None:
    assert [bench.thread_counts(n) for n in (1, 2, 6, 8)] == [[1], [1, 2], [1, 2, 4, 6], [1, 2, 4, 8]]


def test_bench_of_perception_as_json() -> None:
    facts = json_of("perception", "--seconds", "0.1")
    assert facts["build_profile"] == BUILD_PROFILE
    assert facts["turns"] >= 3
    stages = {stage["name"]: (stage["own"], stage["plain"]) for stage in facts["stages"]}
    assert stages["deproject"][0] is None
    assert stages["crop"][1] is None
    assert all(min(stages[name]) > 0 for name in ("plane", "outliers", "clusters", "voxels", "normals"))
    assert facts["own"] > 0
    assert facts["ratio"] > 0
    assert facts["descriptor_ratio"] > 0


def test_bench_of_perception_in_words() -> None:
    text = output("perception", "--seconds", "0.1")
    assert re.search(r"^  stage +beltsort +plain Open3D\n  deproject +- +\d", text, re.MULTILINE)
    assert re.search(r"The plain pipeline takes \d+\.\d times as long\.\n", text)


def test_the_stages_of_perception_are_perception() -> None:
    cell, config = CellConfig(), PerceptionConfig()
    simulated = SimulatedCell([3, 0], cell, seed=1)
    scan = simulated.scan(not_before=simulated.move_to(2, "move"))
    segmented = segment(scan, cell.layout, config)
    expected = [describe(p, segmented.camera, config) for p in segmented.objects if p is not None]
    staged = own_stages(scan, cell, config, Stopwatch())
    assert len(staged) == 2
    assert np.array_equal(staged, expected)
    assert np.shape(plain_stages(scan, cell, config, Stopwatch())) == (2, 308)
