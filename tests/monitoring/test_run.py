"""`beltsort run` with a log and metrics, and the backup of its run."""

import json
import re
import shlex
from pathlib import Path

import pytest

from beltsort.cli import exit_codes, main
from tests.cli.cells import cell_file
from tests.cli.test_run import FULL_BIN

pytestmark = pytest.mark.process


def test_a_run_logs_and_serves_metrics(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--log", "run.log", "--log-format", "json", "--metrics", "0"]
    assert main(["run", cell_file(folder, FULL_BIN), "--objects", "2", *options]) == exit_codes.TRY_AGAIN
    said = capsys.readouterr().err
    assert re.search(r"^metrics: http://127\.0\.0\.1:\d+/metrics$", said, re.MULTILINE)
    resume = re.search(r"beltsort run .*--resume.*", said)
    assert resume is not None
    words = shlex.split(resume[0])
    assert " ".join(options) in resume[0]
    lines = [json.loads(line) for line in (folder / "run.log").read_text().splitlines()]
    assert [line["message"] for line in lines if line["logger"].endswith(".commander")]
    assert main([*words[1:2], cell_file(folder), *words[3:]]) == 0
    lines = [json.loads(line) for line in (folder / "run.log").read_text().splitlines()]
    assert lines[-1]["message"] == "ended: done"
    assert len({line["run"] for line in lines if "run" in line}) == 1
    capsys.readouterr()
    assert main(["backup", "runs", "copy", "--json"]) == 0
    copied = json.loads(capsys.readouterr().out)
    assert copied["at_belt_end"] == 2
    assert main(["show", "copy"]) == 0
    assert "2 sorted" in capsys.readouterr().out


def test_what_cannot_be_opened_is_told_before_anything_moves(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", cell_file(folder), "--log", "none/run.log"]) == exit_codes.WRONG
    assert re.search(r"none/run\.log cannot be written", capsys.readouterr().err)
    assert not (folder / "runs").exists()
