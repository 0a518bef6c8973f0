"""Bags that are damaged, cut short or no bags at all give a clear error, and nothing else."""

import random
import sys
from pathlib import Path

import numpy as np
import pytest

from beltsort.cell.replay import Replay, ReplayOptions
from beltsort.errors import CellError
from tests.cell.replay import bags

IMAGE = np.full((10, 20, 3), 0.5)


def whole(directory: Path, form: str) -> Path:
    record = [bags.stop(0.0, "/viewpoint", "p1")]
    for n in range(5):
        record += [bags.transform(n, "world", "camera", (0.0, 0.0, 1.0)), bags.cloud(n, IMAGE)]
    return bags.write(directory, form, record)


def play(path: Path) -> None:
    """Play back every scan."""
    options = ReplayOptions(str(path), ("p1",), scan_topic="/camera/points", viewpoint_topic="/viewpoint")
    with Replay(options) as cell:
        cell.move_to(0, "one")
        for _ in range(5):
            assert cell.scan(not_before=0.0).points.shape == IMAGE.shape


def storage(path: Path) -> Path:
    """Return the file that holds the messages."""
    return path if path.is_file() else next(file for file in path.iterdir() if file.suffix != ".yaml")


@pytest.mark.parametrize("form", bags.FORMATS)
@pytest.mark.parametrize("kept", [0.0, 0.01, 0.3, 0.7, 0.9])
def test_a_truncated_bag(form: str, kept: float, tmp_path: Path) -> None:
    path = whole(tmp_path, form)
    file = storage(path)
    data = file.read_bytes()
    file.write_bytes(data[: int(kept * len(data))])
    with pytest.raises(CellError, match=r"/record.*\bROS bag\b.*\bsqlite3 or mcap\b"):
        play(path)


@pytest.mark.parametrize("form", bags.FORMATS)
def test_damaged_bytes_never_end_in_anything_but_an_error(form: str, tmp_path: Path) -> None:
    path = whole(tmp_path, form)
    file = storage(path)
    data = file.read_bytes()
    rng = random.Random(1)
    refused = 0
    for _ in range(12):
        damaged = bytearray(data)
        for _ in range(20):
            damaged[rng.randrange(len(data))] = rng.randrange(256)
        file.write_bytes(damaged)
        try:
            play(path)
        except CellError:
            refused += 1
    assert refused > 0


@pytest.mark.parametrize("form", ["sqlite3", "mcap"])
@pytest.mark.parametrize(
    "text", ["", "]", "rosbag2_bagfile_information: 3", "rosbag2_bagfile_information: {}"]
)
def test_damaged_metadata(form: str, text: str, tmp_path: Path) -> None:
    path = whole(tmp_path, form)
    (path / "metadata.yaml").write_text(text)
    with pytest.raises(CellError, match=r"(?s)/record.*\bROS bag\b"):
        play(path)


@pytest.mark.parametrize("name", ["absent.bag", "absent", "table.csv"])
def test_no_bag_at_all(name: str, tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("a,b\n")
    with pytest.raises(CellError, match=rf"{name}\b.*\bROS bag\b"):
        play(tmp_path / name)


def test_one_file_of_a_bag_is_a_bag(tmp_path: Path) -> None:
    play(storage(whole(tmp_path, "mcap")))


@pytest.mark.parametrize("form", bags.FORMATS)
def test_a_bag_without_messages(form: str, tmp_path: Path) -> None:
    path = bags.write(tmp_path, form, [])
    with pytest.raises(CellError):
        play(path)


def test_without_rosbags_the_error_names_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = whole(tmp_path, "mcap")
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(CellError, match=r"\brosbags\b.*pip install 'beltsort\[replay\]'"):
        play(path)
