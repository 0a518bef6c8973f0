"""beltsort throughput."""

import json
from pathlib import Path

import pytest

from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.throughput import cell_throughput
from beltsort.models import paper
from beltsort.planning.throughput import ArmTimes, throughput
from tests.cellfile.test_moving import EXAMPLE, changed
from tests.cli.running import command, json_of, output

OPTIONS = ["--runs", "5", "--objects", "6", "--seed", "3"]


def test_throughput_says_the_same_as_the_library(tmp_path: Path) -> None:
    words = ["most-urgent:0.9", "stop-and-go:threshold:0.9"]
    figure = tmp_path / "figure.png"
    more = ["--speeds", "0.05", "0.1", "--spacing", "0.1", "--move", "0.4", "--figure", str(figure)]
    found = json_of("throughput", "paper", "--policies", *words, *more, *OPTIONS)
    assert found.pop("command_line").startswith("beltsort throughput paper --policies most-urgent:0.9 ")
    # Half a place and one place per second.
    assert [result["ticks_per_place"] for result in found["results"]] == [4, 4, 2, 2]
    times = ArmTimes(move=0.4)
    assert found == throughput(paper(), words, [30, 60], times, objects=6, runs=5, seed=3).to_dict()
    assert figure.stat().st_size > 1000


def test_throughput_in_words() -> None:
    text = output("throughput", "paper", "--speeds", "10", "--purity", "0.1", *OPTIONS)
    assert "least purity" in text
    assert "a purity of at least 0.1 in every bin:\n  moving-search:1: " in text
    assert text.count("at 10 places per minute") == 3


@pytest.mark.parametrize(
    ("options", "named"),
    [(["--spacing", "0"], "--spacing"), (["--policies", "most"], "most-urgent"), (["--tick", "0"], "tick")],
)
def test_options_that_make_no_sense_are_refused(options: list[str], named: str) -> None:
    done = command("throughput", "paper", *options)
    assert done.returncode != 0
    assert named in done.stderr


def test_a_cell_is_studied_as_by_the_library(tmp_path: Path) -> None:
    path = changed(tmp_path, ("exposure = 0.03", "exposure = 0.0"))
    options = ["--policies", "most-urgent:0.8", "--speeds", "30", "--runs", "1", "--objects", "2"]
    done = command("throughput", str(path), *options, "--seed", "4", "--json")
    assert done.stderr == "runs 100 %\n"
    found = json.loads(done.stdout)
    assert found.pop("command_line").endswith("--seed 4 --json")
    alone = cell_throughput(
        CellDescription.load(path), ["most-urgent:0.8"], [30], objects=2, runs=1, seed=4, workers=1
    ).to_dict()
    alone["seconds"]["move"] = [list(row) for row in alone["seconds"]["move"]]
    assert found == alone


def test_options_for_models_are_refused_with_a_cell_and_errors_name_it() -> None:
    done = command("throughput", str(EXAMPLE), "--reach", "1", "--set", "r_min=5")
    assert done.returncode != 0
    assert "--set, --reach and a cell file are given" in done.stderr
    done = command("throughput", str(EXAMPLE.with_name("simulated.toml")))
    assert done.returncode != 0
    assert "simulated.toml is not a valid cell file:\nmoving: is missing" in done.stderr
