"""Bags that are damaged, cut short or no bags at all give a clear error, and nothing else."""

import random
import sys
from pathlib import Path

import numpy as np
import pytest

from beltsort.drivers.replay import Replay, ReplayOptions
from beltsort.errors import CellError, MissingExtraError
from tests.drivers.replay import bags

IMAGE = np.full((10, 20, 3), 0.5)


def record() -> list[bags.Message]:
    messages = [bags.stop(0.0, "/viewpoint", "p1")]
    for n in range(5):
        messages += [bags.transform(n, "world", "camera", (0.0, 0.0, 1.0)), bags.cloud(n, IMAGE)]
    return messages


def whole(directory: Path, form: str) -> Path:
    return bags.write(directory, form, record())


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


@pytest.mark.parametrize("form", bags.FORMATS)
def test_a_topic_that_nobody_needs_may_be_of_any_type(form: str, tmp_path: Path) -> None:
    play(bags.write(tmp_path, form, record(), odd=True))


def test_a_recording_that_was_not_finished_says_what_to_do(tmp_path: Path) -> None:
    path = whole(tmp_path, "bag")
    active = path.rename(tmp_path / "record.bag.active")
    with pytest.raises(CellError, match=r"\brosbag reindex \S*/record\.bag\.active\b"):
        play(active)
    folder = whole(tmp_path, "mcap")
    (folder / "metadata.yaml").unlink()
    with pytest.raises(CellError, match=r"\bros2 bag reindex \S*/record_mcap\b.*\.mcap\b"):
        play(folder)
    play(storage(folder))


@pytest.mark.parametrize(("behind", "refused"), [(0.3, False), (12.0, True), (-12.0, True)])
def test_clocks_that_differ_are_told(behind: float, refused: bool, tmp_path: Path) -> None:
    late = [
        message._replace(time=message.time + 20.0 + behind * (message.topic == "/camera/points"))
        for message in [*record(), *(bags.stop(n, "/viewpoint", "p1") for n in range(5))]
    ]
    path = bags.write(tmp_path, "mcap", sorted(late, key=lambda message: message.time))
    if not refused:
        play(path)
        return
    with pytest.raises(CellError, match=r"\bclocks\b.*/camera/points\b.*\b12\.000 s\b"):
        play(path)


def test_a_clock_that_is_set_back_is_told(tmp_path: Path) -> None:
    messages = [bags.stop(0.0, "/viewpoint", "p1")]
    messages += [bags.cloud(n - 60.0 * (n > 3) + 100.0, IMAGE)._replace(time=n + 100.0) for n in range(6)]
    with pytest.raises(CellError, match=r"/camera/points jumps back by 59\.000 s\b"):
        play(bags.write(tmp_path, "mcap", messages))


def test_without_rosbags_the_error_names_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = whole(tmp_path, "mcap")
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    with pytest.raises(MissingExtraError, match=r"\brosbags\b.*pip install 'beltsort\[replay\]'"):
        play(path)
