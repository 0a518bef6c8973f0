"""The record of calls: its size is bounded, its lines are whole."""

import json
from pathlib import Path

import pytest

from beltsort.cell.wrappers.recorder import Call, Recorded
from beltsort.errors import JournalNotWrittenError
from beltsort.sorting.call_log import CALLS, CallLog, calls_in


def call(number: int) -> Recorded:
    return Recorded("belt", Call("advance_to", number, f"a-{number}"), 0.0, 0.1, None)


def numbers(folder: Path) -> list[int]:
    lines = [line for file in calls_in(folder) for line in file.read_text().splitlines()]
    return [json.loads(line)["call"]["target"] for line in lines]


def test_the_newest_calls_are_kept(tmp_path: Path) -> None:
    log = CallLog(tmp_path, largest=1_000, keep=2)
    for number in range(100):
        log(call(number))
    assert [file.name for file in calls_in(tmp_path)] == [f"{CALLS}.2", f"{CALLS}.1", CALLS]
    assert all(file.stat().st_size <= 1_000 for file in calls_in(tmp_path))
    kept = numbers(tmp_path)
    assert kept == list(range(kept[0], 100))
    assert len(kept) > 12


def test_a_disk_that_is_full_is_told_as_that_of_the_journal(tmp_path: Path) -> None:
    with pytest.raises(JournalNotWrittenError, match=r"/none/calls\.jsonl\b.*\bdisk\b"):
        CallLog(tmp_path / "none")(call(0))


def test_a_line_that_the_disk_took_in_part_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = CallLog(tmp_path)
    log(call(0))
    opened = Path.open

    def full(path: Path, *arguments: object, **options: object) -> object:
        file = opened(path, *arguments, **options)  # type: ignore[call-overload]  # passed on as given
        write = file.write

        class Full:
            def __getattr__(self, name: str) -> object:
                return getattr(file, name)

            def __enter__(self) -> "Full":
                return self

            def __exit__(self, *_: object) -> None:
                file.close()

            def write(self, line: bytes) -> int:
                return int(write(line[:7]))

        return Full()

    with monkeypatch.context() as patched:
        patched.setattr(Path, "open", full)
        with pytest.raises(JournalNotWrittenError, match=r"\btook 7 of \d+ bytes\b"):
            log(call(1))
    log(call(2))
    assert numbers(tmp_path) == [0, 2]
