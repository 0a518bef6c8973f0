"""Commands whose reader leaves (`| head`) end quietly."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.sorting.killed_run import run

from .running import PAPER

pytestmark = pytest.mark.process

FEW = ("--batches", "2")
BUFFERED = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
"""An environment in which standard output is written at the end, not line by line."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("run")
    run(folder, "never", resume=False)
    return str(folder)


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["run", "--help"],
        ["completion", "bash"],
        ["info"],
        ["plan", PAPER, "--trials", "100", "--explain", "--depth", "6"],
        ["plan", PAPER, "--trials", "100", "--explain", "--depth", "6", "--json"],
        ["evaluate", PAPER, "--policy", "threshold:0.9", *FEW],
        ["compare", PAPER, "--policies", "threshold:0.9", "one-object", *FEW, "--json"],
        ["solve", PAPER, "--positions", "1", "--seconds", "0.2"],
        ["show", "RUN"],
        ["show", "RUN", "--json"],
        ["explain", "RUN", "--object", "1", "--depth", "6"],
        ["explain", "RUN", "--step", "1", "--depth", "6", "--json"],
    ],
    ids=" ".join,
)
def test_a_reader_that_has_left(arguments: list[str], folder: str) -> None:
    words = [folder if word == "RUN" else word for word in arguments]
    command = [sys.executable, "-m", "beltsort", *words]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=BUFFERED
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        errors = process.stderr.read()
    assert errors == ""
    assert process.returncode == 128 + signal.SIGPIPE


def test_head(folder: str) -> None:
    """`show --json` of a run is more than a pipe holds."""
    show = f'"{sys.executable}" -m beltsort show "{folder}" --json'
    done = subprocess.run(
        ["bash", "-c", f"{show} | head -1; exit ${{PIPESTATUS[0]}}"], capture_output=True, text=True
    )
    assert (done.stdout, done.stderr) == ("{\n", "")
    assert done.returncode == 128 + signal.SIGPIPE
    assert Path(folder, "journal.sqlite").exists()
