"""Ctrl-C and kill -9 lose what was under way, and nothing else."""

import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from beltsort.sweep.engine import FILE, RowStore
from tests.sweep.gated_run import ALL, FREE, run
from tests.waiting import PATIENCE, alive, wait_until

pytestmark = pytest.mark.process


def notes(folder: Path) -> list[list[str]]:
    path = folder / "notes"
    return [line.split() for line in path.read_text().splitlines()] if path.exists() else []


def finished(folder: Path) -> int:
    if not (folder / "store" / FILE).exists():
        return 0
    with RowStore(folder / "store") as store:
        return len(store.values())


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGKILL])
def test_what_was_finished_is_not_done_again(tmp_path: Path, ending: signal.Signals) -> None:
    script = [sys.executable, "-m", "tests.sweep.gated_run", str(tmp_path)]
    process = subprocess.Popen(script, stderr=subprocess.DEVNULL)
    try:
        wait_until(
            lambda: finished(tmp_path) == FREE and len(notes(tmp_path)) == ALL,
            "all but two points are finished",
        )
        process.send_signal(ending)
        assert process.wait(PATIENCE) == -ending  # though two points still wait at the gate
    finally:
        process.kill()
        process.wait()
    wait_until(lambda: not any(alive(int(pid)) for _, pid in notes(tmp_path)), "the workers end")

    (tmp_path / "gate").touch()
    assert run(tmp_path) == [x * x for x in range(ALL)]
    begun = Counter(int(x) for x, _ in notes(tmp_path))
    assert begun == {x: 1 if x < FREE else 2 for x in range(ALL)}
