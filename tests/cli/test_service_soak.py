"""A service that is ended at random moments, again and again: nothing is lost, nothing is sorted twice."""

import fcntl
import os
import pty
import random
import resource
import signal
import subprocess
import termios
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from beltsort.cli import exit_codes
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.record import progress_in
from beltsort.sorting.status import status_of
from tests.account import Account
from tests.cli.running import command
from tests.cli.service_manager import Manager, Started, Unit
from tests.cli.test_ends import homed, modbus_cell, the_run
from tests.cli.test_service import UNLIMITED, check_sorted, service
from tests.contract.peers import ModbusPeer

pytestmark = [pytest.mark.soak, pytest.mark.timeout(1800)]

TIMES, LONGEST, SEED = 20, 3.0, 2026


@pytest.fixture
def peer(tmp_path: Path) -> Iterator[ModbusPeer]:
    peer = ModbusPeer(tmp_path)
    try:
        peer.start("--speed", "10")  # a sort takes 0.3 s, so that many ends come in the middle of one
        yield peer
    finally:
        peer.close()


class Disturbance:
    """Does something to the process, once, up to `LONGEST` seconds after it was ready; stops the last run.

    A process that waits for an answer at its terminal is given one.
    """

    def __init__(self, peer: ModbusPeer, what: Callable[[Started], None]) -> None:
        self._peer, self._what, self._rng, self.done = peer, what, random.Random(SEED), 0
        self._due: dict[int, float] = {}

    def __call__(self, started: Started) -> None:
        pid = started.process.pid
        if not started.ready:
            return
        if pid not in self._due:
            self._due[pid] = time.monotonic() + self._rng.uniform(0.0, LONGEST)
        if time.monotonic() < self._due[pid]:
            return
        run = the_run(Path.cwd())
        if status_of(run).question is not None and started.process.poll() is None:
            look_and_settle(run, self._peer)
            self._due[pid] = time.monotonic() + self._rng.uniform(1.0, LONGEST)
            return
        self._due[pid] = float("inf")
        if self.done == TIMES:
            assert command("stop", "latest").returncode == 0
        else:
            self.done += 1
            self._what(started)


def soak(
    folder: Path, peer: ModbusPeer, account: Account, manager: Manager, disturbance: Disturbance, name: str
) -> Counter[int]:
    """Run the service until it has been disturbed often and stopped, and return how often it ended how."""
    answers = 0
    while (code := manager.run(disturbance)) != exit_codes.DONE:
        if code == exit_codes.NEEDS_PERSON:
            answers += 1
            look_and_settle(the_run(folder), peer)
        else:
            assert code == exit_codes.NOT_WRITTEN, (folder / "service.log").read_text()[-3000:]
    account.injected(name, disturbance.done)
    progress = check_sorted(the_run(folder), peer, first=3)
    account.lost(name, abs(sum(peer.push("look")["bins"]) - (progress.index + progress.taken - 3)))
    codes = Counter(manager.codes)
    print(
        f"\n{name}: {disturbance.done} times, {progress.index - 3} objects, exit codes {dict(codes)}, "
        f"{answers} answers"
    )
    return codes


def look_and_settle(run: Path, peer: ModbusPeer) -> None:
    """Answer the question about a sort that was broken off, after a look into the bins."""
    decided = len(progress_in(run / JOURNAL).decisions)
    answer = "done" if sum(peer.push("look")["bins"]) == decided else "not-done"
    assert command("settle", str(run), answer).returncode == 0


@pytest.fixture
def unit(folder: Path, peer: ModbusPeer) -> Unit:
    unit = service(modbus_cell(folder, peer, UNLIMITED))
    homed(peer, 3).close()
    return unit


def test_signals(folder: Path, peer: ModbusPeer, unit: Unit, account: Account) -> None:
    rng = random.Random(SEED)
    signals = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
    disturbance = Disturbance(peer, lambda started: started.process.send_signal(rng.choice(signals)))
    codes = soak(folder, peer, account, Manager(unit), disturbance, "restarts")
    ends = {0, exit_codes.NEEDS_PERSON, -signal.SIGKILL, 128 + signal.SIGTERM, 128 + signal.SIGINT}
    assert set(codes) <= ends
    assert codes[0] == 1
    interrupted = codes.total() - codes[exit_codes.NEEDS_PERSON] - codes[0]
    assert 0 < interrupted <= TIMES, "a signal may also meet a start that ends because it needs a person"


def test_full_disks(folder: Path, peer: ModbusPeer, unit: Unit, account: Account) -> None:
    """From some moment on no file can grow; the next process has room again."""

    def fill(started: Started) -> None:
        resource.prlimit(started.process.pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))

    def silent(unit: Unit, environment: dict[str, str]) -> "subprocess.Popen[bytes]":
        null = subprocess.DEVNULL
        return subprocess.Popen(
            unit.command, cwd=unit.folder, env=environment, stdin=null, stdout=null, stderr=null
        )

    codes = soak(folder, peer, account, Manager(unit, launch=silent), Disturbance(peer, fill), "full disk")
    assert set(codes) <= {0, exit_codes.NEEDS_PERSON, exit_codes.NOT_WRITTEN}
    assert codes[exit_codes.NOT_WRITTEN] == TIMES


def test_closed_terminals(folder: Path, peer: ModbusPeer, unit: Unit, account: Account) -> None:
    terminals: list[int] = []

    def at_a_terminal(unit: Unit, environment: dict[str, str]) -> "subprocess.Popen[bytes]":
        own, its = pty.openpty()
        terminals.append(own)
        os.set_blocking(own, False)
        process = subprocess.Popen(
            unit.command,
            cwd=unit.folder,
            env={**environment, "TERM": "xterm"},
            stdin=its,
            stdout=its,
            stderr=its,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )
        os.close(its)
        return process

    def close(_started: Started) -> None:
        os.close(terminals.pop())

    class ReadingDisturbance(Disturbance):
        """Also reads what the process writes, so that the terminal is never full."""

        def __call__(self, started: Started) -> None:
            if terminals:
                with suppress(OSError):  # nothing to read
                    os.read(terminals[-1], 1_000_000)
            super().__call__(started)

    manager = Manager(unit, launch=at_a_terminal)
    codes = soak(folder, peer, account, manager, ReadingDisturbance(peer, close), "closed terminal")
    close(manager.starts[-1])
    assert set(codes) <= {0, exit_codes.NEEDS_PERSON, 128 + signal.SIGHUP}
    assert codes[128 + signal.SIGHUP] == TIMES
