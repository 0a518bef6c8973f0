"""Labels on the disk."""

import re
import sqlite3
import threading
from pathlib import Path

import pytest

from beltsort.errors import RecordingError
from beltsort.tables.log import LabelLog, Labels, label_missing


def test_labels_are_kept_and_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "model.labels"
    with LabelLog(path, {"seed": "1"}) as log:
        log.append({"a": (1, None)})
    with LabelLog(path, {"seed": "1"}) as log:
        log.append({"a": (0, 0), "b": (2, 2)})
        assert log.labels() == {"a": (1, None), "b": (2, 2)}


def test_what_is_appended_outlives_the_writer(tmp_path: Path) -> None:
    path = tmp_path / "model.labels"
    LabelLog(path).append({"a": (1, None)})  # never closed
    assert LabelLog(path).labels() == {"a": (1, None)}


@pytest.mark.parametrize("settings", [{"seed": "2"}, {}, {"seed": "1", "cell": "real"}])
def test_labels_of_other_settings_are_refused(tmp_path: Path, settings: dict[str, str]) -> None:
    path = tmp_path / "model.labels"
    LabelLog(path, {"seed": "1"}).close()
    with pytest.raises(
        RecordingError, match=r"model\.labels\b.*\b(seed 1 .*\b(2|None)|cell None .*\breal)\b"
    ):
        LabelLog(path, settings)


def test_another_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("no database " * 100)
    for path in (tmp_path / "text", tmp_path, tmp_path / "missing" / "labels"):
        with pytest.raises(RecordingError, match=rf"{re.escape(str(path))} .*`beltsort estimate`"):
            LabelLog(path)


def test_a_file_that_another_process_makes_is_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "model.labels"
    other = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    other.execute("CREATE TABLE unrelated (x)")
    other.execute("BEGIN IMMEDIATE")
    soon = threading.Timer(0.2, other.execute, ["COMMIT"])
    soon.start()
    with LabelLog(path) as log:
        log.append({"a": (1,)})
    soon.join()
    assert LabelLog(path).labels() == {"a": (1,)}


def test_only_what_is_missing_is_labelled() -> None:
    log, done = LabelLog(), []
    log.append({"a1": (0,), "a2": (0,), "b1": (0,)})

    def task(piece: str) -> Labels:
        done.append(piece)
        return {f"{piece}1": (1,), f"{piece}2": (1,)}

    label_missing(task, ["a", "b", "c"], lambda piece: [f"{piece}1", f"{piece}2"], log, 1, None)
    assert done == ["b", "c"]
    expected = {"a1": (0,), "a2": (0,), "b1": (0,), "b2": (1,), "c1": (1,), "c2": (1,)}
    assert log.labels() == expected
