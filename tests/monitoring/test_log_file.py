"""The log file of a run: its lines, levels and limits."""

import json
import logging
import re
from pathlib import Path
from typing import Any, get_args

import pytest

from beltsort.errors import JournalError
from beltsort.monitoring.entry_logger import level_of
from beltsort.monitoring.log_file import PACKAGE, LogFile
from beltsort.sorting.entries import AnyContent
from beltsort.sorting.entry_format import content_of
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal import Entry, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.record import progress_in
from tests.monitoring.runs import resumed, run_of

KINDS = Path(__file__).parents[1] / "fixtures" / "journal" / "kinds.jsonl"
LINE = re.compile(r"[\d-]{10}T\d\d:\d\d:\d\d\.\d{3}Z (DEBUG|INFO|WARNING|ERROR) +(run=\w{8} )?.*beltsort\.")


def silent(line: str) -> None:
    raise AssertionError(line)


def lines_of(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_every_line_says_where_the_run_is(tmp_path: Path) -> None:
    with LogFile(tmp_path / "run.log", silent, format="json") as log:
        run_of(tmp_path, log)
    lines = lines_of(tmp_path / "run.log")
    entries = read_journal(tmp_path / JOURNAL)
    assert {line["run"] for line in lines} == {entries[0].data["run"]}
    assert all(LINE.match(f"{line['time']} {line['level'].upper()} beltsort.") for line in lines)
    told = [(line["level"], line["message"]) for line in lines if "kind" in line]
    assert ("warning", "unusable scan: no point is finite") in told
    assert ("info", "empty cup, skipped") in told
    assert told[-1] == ("info", "ended: done")
    failed = [line for line in lines if line.get("kind") == "outcome"]
    assert [(line["level"], line["object"], line["step"]) for line in failed] == [("warning", 2, 4)]
    (again,) = [line for line in lines if line["logger"] == "beltsort.sorting.commander"]
    assert (again["object"], again["step"]) == (2, 4), "what other modules log is placed too"
    assert re.search(r"again in 0 s: .*\bfull\b", again["message"])
    decided = [line for line in lines if line.get("kind") == "decision"]
    assert [line["object"] for line in decided] == [0, 2, 3]
    by_number = {entry.number: entry for entry in entries}
    assert all(by_number[line["entry"]].kind == line["kind"] for line in lines if "entry" in line)
    assert "plan" not in {line.get("kind") for line in lines}, "debug"


def test_debug_has_every_entry_as_text(tmp_path: Path) -> None:
    with LogFile(tmp_path / "run.log", silent, level="debug") as log:
        run_of(tmp_path, log)
    lines = (tmp_path / "run.log").read_text().splitlines()
    assert all(LINE.match(line) for line in lines)
    entries = [line for line in lines if " beltsort.run: " in line]
    assert len(entries) == len(read_journal(tmp_path / JOURNAL))
    assert any("step=1 object=0 beltsort.run: chosen move 1" in line for line in entries)


def test_a_resumed_run_counts_on(tmp_path: Path) -> None:
    with LogFile(tmp_path / "run.log", silent, format="json") as log, pytest.raises(HeldError):
        run_of(tmp_path, log, refused=9)
    before = lines_of(tmp_path / "run.log")
    assert (before[-1]["level"], before[-1]["kind"]) == ("error", "end")
    progress = progress_in(tmp_path / JOURNAL)
    with LogFile(tmp_path / "run.log", silent, format="json") as log:
        log.entries.resume(progress)
        resumed(tmp_path, log, first=progress.index)
    after = lines_of(tmp_path / "run.log")[len(before) :]
    assert {line["run"] for line in after} == {progress.run}
    assert max(line["step"] for line in after) == progress_in(tmp_path / JOURNAL).steps


def test_the_log_is_bounded(tmp_path: Path) -> None:
    with LogFile(tmp_path / "run.log", silent, level="debug", largest=2_000, keep=2) as log:
        run_of(tmp_path, log)
    files = sorted(file.name for file in tmp_path.glob("run.log*"))
    assert files == ["run.log", "run.log.1", "run.log.2"]
    assert all((tmp_path / name).stat().st_size <= 2_000 for name in files)


def test_a_log_that_cannot_be_written_is_told_once_and_ends_no_run(tmp_path: Path) -> None:
    said: list[str] = []
    with LogFile(tmp_path / "run.log", said.append) as log:
        assert log._handler.stream is not None
        log._handler.stream.close()
        log._handler.stream = Path("/dev/full").open("w")  # noqa: SIM115 (the handler closes it)
        report = run_of(tmp_path, log)
    assert len(report.decisions) == 3
    assert len(said) == 1
    assert re.search(r"/run\.log cannot be written; the run goes on\b", said[0])
    assert "ended: done" in (tmp_path / "run.log").read_text(), "it is tried again"
    assert "unheard" not in [entry.kind for entry in read_journal(tmp_path / JOURNAL)]
    with pytest.raises(JournalError, match=r"/none/run\.log\b.*\bname a file\b"):
        LogFile(tmp_path / "none" / "run.log", silent)


def test_an_error_that_nobody_foresaw_has_its_traceback(tmp_path: Path) -> None:
    for format in ("text", "json"):
        path = tmp_path / format
        with pytest.raises(ZeroDivisionError), LogFile(path, silent, format=format):
            _ = 1 / 0
        assert "Traceback" in path.read_text()
    assert "ZeroDivisionError" in lines_of(tmp_path / "json")[0]["exception"]


def test_logging_is_as_before_afterwards(tmp_path: Path) -> None:
    package = logging.getLogger(PACKAGE)
    before = package.level, list(package.handlers)
    with LogFile(tmp_path / "run.log", silent, level="debug"):
        assert package.level == logging.DEBUG
    assert (package.level, package.handlers) == before
    assert any(isinstance(handler, logging.NullHandler) for handler in package.handlers)


@pytest.mark.parametrize("stored", lines_of(KINDS), ids=lambda s: s["kind"])
def test_every_kind_of_entry_has_a_level_and_a_text(
    stored: dict[str, Any], caplog: pytest.LogCaptureFixture
) -> None:
    from beltsort.monitoring.entry_logger import EntryLogger, _text_of

    content = content_of(stored["kind"], stored["data"])
    assert level_of(content) in (logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR)
    assert isinstance(content, get_args(AnyContent))
    assert _text_of(content)
    if stored["kind"] in ("start", "outcome", "state", "skip", "end"):
        with caplog.at_level(logging.DEBUG, PACKAGE):
            EntryLogger()(Entry(1, "", None, content))
        assert caplog.messages[0]
