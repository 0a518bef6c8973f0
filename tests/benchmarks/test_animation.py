"""The animation of README is drawn from a run."""

from pathlib import Path

import pytest
from PIL import Image

from benchmarks.animation import LONG, SEED, SIZE, states, write

pytestmark = pytest.mark.slow


def test_beliefs_and_bins_are_those_of_the_run() -> None:
    shown = list(states(SEED, 2))
    for state, milliseconds in shown:
        assert state.belief.sum(axis=1) == pytest.approx(1.0)
        assert milliseconds > 0
    looks = [state for state, milliseconds in shown if state.scanning and milliseconds == LONG]
    assert [state.said[1] for state in looks[:3]] == ["look from p3", "look from p2", "look from p1"]
    assert sum(shown[-1][0].binned) == 2


def test_the_file_is_an_animation(tmp_path: Path) -> None:
    write(tmp_path / "run.webp", SEED, objects=1)
    with Image.open(tmp_path / "run.webp") as image:
        assert getattr(image, "n_frames", 1) > 10
        assert image.width / image.height == pytest.approx(SIZE[0] / SIZE[1])
