"""The models that come with the package."""

from pathlib import Path

import pytest

import beltsort
from beltsort import ModelError, SortingModel, models
from beltsort.cli import main

from .core.models import PAPER


def test_the_papers_instance() -> None:
    assert models.paper() == SortingModel.load(PAPER)


@pytest.mark.parametrize("name", models.PACKAGED)
def test_packaged_models_by_name(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert beltsort.models.load(name) == models.PACKAGED[name]()
    assert main(["plan", name, "--trials", "2"]) == 0
    assert "Belief, position 1 at the belt end" in capsys.readouterr().out


def test_a_file_of_that_name_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    models.paper().replace(r_min=7).save("paper")
    assert models.load("paper").r_min == 7.0
    with pytest.raises(
        ModelError, match=r"papr: neither a file nor a packaged model; did you mean .paper.\?"
    ):
        models.load("papr")


def test_a_missing_file_is_told_from_the_nearest_in_its_folder(tmp_path: Path) -> None:
    models.paper().save(tmp_path / "model.json")
    for name in ("other.json", "rows.csv"):
        (tmp_path / name).write_text("{}")
    with pytest.raises(
        ModelError, match=r"modle\.json: there is no such file; did you mean '.*/model\.json'\?"
    ) as raised:
        models.load(tmp_path / "modle.json")
    assert "other.json" in str(raised.value)
    assert "rows.csv" not in str(raised.value)
    alone = tmp_path / "alone"
    alone.mkdir()
    with pytest.raises(
        ModelError,
        match=r"m\.json: there is no such file; there is no model file in .*; packaged models: paper",
    ):
        models.load(alone / "m.json")
    with pytest.raises(ModelError, match=r"there is no directory .*/nowhere; correct the path"):
        models.load(tmp_path / "nowhere" / "model.json")
