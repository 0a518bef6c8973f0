"""Ctrl-C and kill -9 lose what was under way, and nothing else."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

from beltsort.experiments.sweep.store import FILE, RowStore
from tests.sweep.gated_run import ALL, FREE, run

DEADLINE = 30.0


def wait_for(what: Callable[[], bool]) -> None:
    deadline = time.monotonic() + DEADLINE
    while not what():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def notes(folder: Path) -> list[list[str]]:
    path = folder / "notes"
    return [line.split() for line in path.read_text().splitlines()] if path.exists() else []


def finished(folder: Path) -> int:
    if not (folder / "store" / FILE).exists():
        return 0
    with RowStore(folder / "store") as store:
        return len(store.values())


def alive(pid: str) -> bool:
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGKILL])
def test_what_was_finished_is_not_done_again(tmp_path: Path, ending: signal.Signals) -> None:
    script = [sys.executable, "-m", "tests.sweep.gated_run", str(tmp_path)]
    process = subprocess.Popen(script, stderr=subprocess.DEVNULL)
    try:
        wait_for(lambda: finished(tmp_path) == FREE and len(notes(tmp_path)) == ALL)
        process.send_signal(ending)
        assert process.wait(DEADLINE) == -ending  # though two points would wait for a minute
    finally:
        process.kill()
        process.wait()
    wait_for(lambda: not any(alive(pid) for _, pid in notes(tmp_path)))

    (tmp_path / "gate").touch()
    assert run(tmp_path) == [x * x for x in range(ALL)]
    begun = Counter(int(x) for x, _ in notes(tmp_path))
    assert begun == {x: 1 if x < FREE else 2 for x in range(ALL)}
