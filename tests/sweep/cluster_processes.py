"""A Dask scheduler and its workers, real processes on loopback."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.waiting import wait_until


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
            process.wait()


def _address(file: Path) -> str:
    """Wait for the file that the scheduler writes, all of it."""

    def address() -> str:
        try:
            return str(json.loads(file.read_text())["address"])
        except (FileNotFoundError, json.JSONDecodeError):
            return ""

    return wait_until(address, "the scheduler starts")
