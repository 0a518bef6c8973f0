"""beltsort calibrate-check."""

import json
from pathlib import Path

import pytest

from beltsort.calibration.promise import promises
from beltsort.cli import main

pytestmark = [pytest.mark.process, pytest.mark.slow]


def test_three_models_sort_the_same_objects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(promises.__kwdefaults__ or {}, "objects", 20)
    figure = tmp_path / "figure.png"
    given = ["calibrate-check", "--objects", "10", "--workers", "1", "--figure", str(figure)]
    assert main([*given, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    names = {"without repeats", "with repeats", "with modes"}
    assert set(told["arms"]) == set(told["promises"]) == names
    assert set(told["differences"]) == names - {"without repeats"}
    assert all(8.0 < promise["promised"] < 10.0 for promise in told["promises"].values())
    assert figure.read_bytes().startswith(b"\x89PNG")
