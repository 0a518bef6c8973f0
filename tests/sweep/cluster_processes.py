"""A Dask scheduler and its workers, real processes on loopback."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

DEADLINE = 20.0


@dataclass(frozen=True)
class Processes:
    address: str
    workers: list[subprocess.Popen[bytes]]


@contextmanager
def cluster(folder: Path, workers: int, options: Sequence[str] = ()) -> Iterator[Processes]:
    """Start them, and stop each by its own process."""
    file = folder / "scheduler.json"
    started: list[subprocess.Popen[bytes]] = []

    def start(module: str, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments, *options]
        process = subprocess.Popen(
            [*command, "--host", "127.0.0.1", "--no-dashboard"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "DASK_TEMPORARY_DIRECTORY": str(folder)},
        )
        started.append(process)
        return process

    try:
        start("dask_scheduler", "--port", "0", "--scheduler-file", str(file))
        address = _address(file)
        yield Processes(
            address,
            [start("dask_worker", address, "--nthreads", "1", "--no-nanny") for _ in range(workers)],
        )
    finally:
        for process in started:
            process.kill()
        for process in started:
            process.wait(DEADLINE)


def _address(file: Path) -> str:
    """Wait for the file that the scheduler writes."""
    deadline = time.monotonic() + DEADLINE
    while not file.exists():
        assert time.monotonic() < deadline, "the scheduler has not started"
        time.sleep(0.05)
    address = json.loads(file.read_text())["address"]
    assert isinstance(address, str)
    return address
