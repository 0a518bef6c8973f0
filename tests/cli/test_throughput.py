"""beltsort throughput."""

from pathlib import Path

import pytest

from beltsort.models import paper
from beltsort.planning.throughput import ArmTimes, throughput
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
