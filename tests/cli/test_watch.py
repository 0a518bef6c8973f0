"""`beltsort watch` as a process: what it prints, how it ends, and what it leaves."""

import itertools
import json
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import beltsort
from beltsort.cli.exit_codes import WRONG
from beltsort.sorting.journal import Journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.requests import read_token, taking_requests
from tests.cli.running import command
from tests.sorting.moving.runs import plant, sort
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted

pytestmark = pytest.mark.process

MODEL = beltsort.SortingModel.load("tests/fixtures/paper.json")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    with Journal(tmp_path / "journal.sqlite") as journal:
        sort_objects(*(ScriptedCell(MODEL), scripted([[0, 1]] * 9), LookOnce(), MODEL, journal), objects=3)
    return tmp_path


@contextmanager
def watching(folder: Path, *options: str) -> Iterator[tuple["subprocess.Popen[str]", str]]:
    """Start the command; yield the process and the address that it has printed."""
    words = [sys.executable, "-m", "beltsort", "watch", str(folder), "--json", "--no-browser", *options]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            lines = list(itertools.takewhile(lambda line: line != "}\n", process.stdout))
            yield process, json.loads("".join([*lines, "}"]))["address"]
        finally:
            process.kill()


def state_at(address: str) -> str:
    with urllib.request.urlopen(f"{address.partition('#')[0]}api/state", timeout=20) as answer:
        return str(json.load(answer)["run"]["state"])


def test_a_run_on_a_belt_that_never_stops_is_watched_but_not_explained(tmp_path: Path) -> None:
    sort(tmp_path, plant())
    with watching(tmp_path) as (_process, address):
        assert state_at(address) == "Complete"
    refused = command("explain", str(tmp_path))
    assert refused.returncode == WRONG
    assert "of a belt that never stops" in refused.stderr
    assert "`beltsort watch`" in refused.stderr


def test_ctrl_c_closes_the_page(folder: Path) -> None:
    with watching(folder) as (process, address):
        assert state_at(address) == "Complete"
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)
    assert (process.returncode, out) == (0, "")
    assert "the page is closed, the run is not" in err
    assert "Traceback" not in err


def test_a_watcher_that_is_killed_leaves_nothing(folder: Path) -> None:
    files = {"journal.sqlite", "journal.sqlite-wal", "journal.sqlite-shm"}
    with Journal(folder / "journal.sqlite", resume=True):
        with watching(folder) as (process, address):
            assert state_at(address) == "Complete"
            process.kill()
        assert {file.name for file in folder.iterdir()} == files
    assert {file.name for file in folder.iterdir()} == {"journal.sqlite"}


def test_control_prints_the_token_where_no_server_sees_it(folder: Path) -> None:
    with taking_requests(folder), watching(folder, "--control") as (_process, address):
        assert address.endswith(f"/#token={read_token(folder)}")
        assert state_at(address) == "Complete"


def test_a_port_that_is_taken_and_one_that_is_none(folder: Path) -> None:
    with watching(folder) as (_process, address):
        port = address.split(":")[2].rstrip("/")
        done = command("watch", str(folder), "--no-browser", "--port", port)
        assert (done.returncode, "in use" in done.stderr) == (WRONG, True)
    done = command("watch", str(folder), "--port", "65536")
    assert done.returncode == WRONG
    assert "expected 0 to 65535" in done.stderr


def test_there_must_be_a_run(tmp_path: Path) -> None:
    done = command("watch", str(tmp_path), "--no-browser")
    assert done.returncode == WRONG
    assert "does not exist" in done.stderr
