"""A run as a service: its unit, what it tells the manager, and what people do to it from outside."""

import json
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.watchdog import longest_step
from beltsort.cli import exit_codes, main
from beltsort.sorting.entries import Requested
from beltsort.sorting.journal import read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.progress import Progress
from beltsort.sorting.status import Condition, status_of
from tests.cli.cells import cell_file
from tests.cli.running import command
from tests.cli.service_manager import Manager, Started, Unit
from tests.cli.test_ends import homed, modbus_cell, the_run
from tests.contract.peers import ModbusPeer
from tests.sorting.test_settling import held

UNLIMITED = ("objects = 10", 'objects = "unlimited"')


@pytest.fixture
def peer(tmp_path: Path) -> Iterator[ModbusPeer]:
    peer = ModbusPeer(tmp_path)
    try:
        peer.start("--speed", "100")
        yield peer
    finally:
        peer.close()


def service(cell: str) -> Unit:
    return Unit.parse(command("service", cell).stdout)


def check_sorted(run: Path, peer: ModbusPeer, first: int) -> Progress:
    """Check that each object was sorted once, into the bin that the journal has."""
    progress = Progress.after(read_journal(run / JOURNAL))
    done = progress.decisions if progress.bin is None else progress.decisions[:-1]
    assert [decision.object for decision in done] == list(range(first, progress.index + progress.taken))
    decided = Counter(decision.label for decision in done)
    bins = peer.push("look")["bins"]
    assert {bin: count for bin, count in enumerate(bins) if count} == decided
    return progress


def test_the_unit(folder: Path) -> None:
    cell = Path(cell_file(folder)).rename(folder / "the cell, 100% $new.toml")
    text = command("service", str(cell)).stdout
    unit = Unit.parse(text)
    python = [sys.executable, "-m", "beltsort", "run"]
    assert unit.command == [*python, str(cell), "--live", "--service", "--allow-hold"]
    assert unit.folder == folder
    assert unit.watchdog >= longest_step(CellDescription.load(cell))
    single = {value for name, value in vars(exit_codes).items() if name.isupper()} - {exit_codes.SIGNALLED}
    signals = {exit_codes.SIGNALLED + number for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM)}
    assert unit.again == {exit_codes.TRY_AGAIN} | signals
    assert unit.again | unit.never | {exit_codes.DONE} == single | signals
    assert command("service", str(cell), "-o", "beltsort.service").returncode == 0
    assert Path("beltsort.service").read_text() == text
    systemd = shutil.which("systemd-analyze")
    if systemd is None:
        pytest.skip("there is no systemd-analyze")
    found = subprocess.run([systemd, "verify", "./beltsort.service"], capture_output=True, text=True)
    assert [line for line in found.stderr.splitlines() if "beltsort.service" in line] == []


def test_a_watchdog_that_is_too_short_is_refused(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("NOTIFY_SOCKET", str(folder / "nobody"))
    monkeypatch.setenv("WATCHDOG_USEC", "2000000")
    assert main(["run", cell_file(folder)]) == exit_codes.WRONG
    assert re.search(r"\bWatchdogSec is 2 s, expected at least 150\b", capsys.readouterr().err)
    assert not Path("runs").exists()


def test_the_newest_run_or_a_new_one(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell = cell_file(folder)
    latest, service = (
        ["run", cell, "--objects", "1", *words] for words in (["--resume", "latest"], ["--service"])
    )
    assert main(latest) == exit_codes.WRONG
    assert re.search(r"\bis finished, or there is none\b", capsys.readouterr().err)
    assert [main(service), main(service)] == [0, 0]
    runs = sorted((folder / "runs").iterdir())
    assert len(runs) == 2
    assert main(latest) == exit_codes.WRONG
    shutil.rmtree(runs[0])
    forget_the_end(runs[1])
    assert main([*service, "--first-object", "3"]) == exit_codes.WRONG
    assert [main(latest), main(latest)] == [0, exit_codes.WRONG]
    forget_the_end(runs[1])
    assert main(service) == 0
    assert list((folder / "runs").iterdir()) == [runs[1]]
    assert command("run", cell, "--objects", "unlimitd").returncode == exit_codes.WRONG


def forget_the_end(run: Path) -> None:
    """Remove the entries after the last intent, as if the process had been killed there."""
    with sqlite3.connect(run / JOURNAL) as database:
        database.execute(
            "DELETE FROM entries WHERE number > (SELECT max(number) FROM entries WHERE kind = 'intent')"
        )
    database.close()


def test_what_a_held_run_needs_is_printed_and_settled(tmp_path: Path) -> None:
    held(tmp_path)
    printed = command("status", str(tmp_path)).stdout
    assert re.search(r": held\nat sort 1: the sort into .* was broken off", printed)
    assert re.search(
        rf"^if object 0 is in .*: beltsort settle {tmp_path} done && beltsort run CELL.toml --live --resume",
        printed,
        re.MULTILINE,
    )
    status = json.loads(command("status", str(tmp_path), "--json").stdout)
    assert (status["condition"], status["question"]["settled"], len(status["next"])) == ("held", None, 2)
    assert command("settle", str(tmp_path), "passed").returncode == exit_codes.WRONG
    assert command("settle", str(tmp_path), "eaten").returncode == exit_codes.WRONG
    done = command("settle", str(tmp_path), "done")
    assert (done.returncode, "to resume: beltsort run" in done.stderr) == (0, True)
    assert "answered: done; to resume it: beltsort run" in command("status", str(tmp_path)).stdout
    assert command("status", str(tmp_path / "nowhere")).returncode == exit_codes.WRONG


def test_what_needs_a_person_is_not_started_again(folder: Path, peer: ModbusPeer) -> None:
    unit = service(modbus_cell(folder, peer, UNLIMITED))
    peer.kill()

    off = [True]

    def switch_on(_started: Started) -> None:
        if len(manager.starts) == 2 and off:
            off.pop()
            peer.start()

    manager = Manager(unit)
    assert manager.run(switch_on) == exit_codes.NEEDS_PERSON  # the belt is not homed
    assert manager.codes == [exit_codes.TRY_AGAIN, exit_codes.NEEDS_PERSON]


@pytest.mark.slow
def test_a_service_that_is_held_killed_hung_and_stopped(folder: Path, peer: ModbusPeer) -> None:
    unit = service(modbus_cell(folder, peer, UNLIMITED))
    homed(peer, 3).close()
    manager = Manager(unit, patience=10.0)
    acts = person(folder, manager)
    assert manager.run(lambda _started: next(acts, None)) == exit_codes.DONE
    assert manager.codes == [-signal.SIGKILL, -signal.SIGKILL, 128 + signal.SIGTERM, 0]
    assert manager.hung == 1
    run = the_run(folder)
    progress = check_sorted(run, peer, first=3)
    assert progress.objects is None
    assert [started.said[-1] for started in manager.starts[2:]] == ["STOPPING=1"] * 2
    assert any(re.match(r"STATUS=object \d+ .*: \d+ ", line) for line in manager.starts[0].said)
    status = json.loads(command("status", "latest", "--json").stdout)
    assert (status["condition"], status["pid"], status["left"]) == ("stopped", None, None)
    assert status["next"][0]["command"].endswith(f"--live --resume {Path('runs') / run.name}")
    assert requests_in(run) == ["hold", "hold", "continue", "hold", "hold", "continue", "stop"]
    assert command("hold", "latest").returncode == exit_codes.WRONG  # it does not go on


def requests_in(run: Path) -> list[str]:
    return [e.content.action for e in read_journal(run / JOURNAL) if isinstance(e.content, Requested)]


def person(folder: Path, manager: Manager) -> Iterator[None]:
    """Hold the run, kill it while held, continue it, let it hang, hold and end it by a signal, stop it."""

    def more_sorted(by: int = 2) -> bool:
        status = status_of(run)
        return manager.starts[-1].ready and status.condition is Condition.RUNNING and status.object >= by

    def until_held(times: int) -> Iterator[None]:
        """Wait until the hold has been journalled so often, and the run waits."""
        while len(requests_in(run)) < times or status_of(run).condition is not Condition.HELD:
            yield

    while not (manager.starts[-1].ready and any((folder / "runs").glob(f"*/{JOURNAL}"))):
        yield
    run = the_run(folder)
    while not more_sorted(5):
        yield
    assert command("hold", str(run)).returncode == 0
    yield from until_held(1)
    pid = manager.starts[-1].process.pid
    assert f"held, process {pid}" in command("status", str(run)).stdout
    manager.starts[-1].process.kill()
    yield from until_held(2)
    assert command("continue", "runs").returncode == 0
    while not more_sorted(8):
        yield
    manager.starts[-1].process.send_signal(signal.SIGSTOP)
    while len(manager.starts) < 3 or not more_sorted(11):
        yield
    # A sort that a signal breaks off would need a person.
    assert command("hold", str(run)).returncode == 0
    yield from until_held(4)
    manager.starts[-1].process.terminate()
    yield from until_held(5)
    assert command("continue", "runs").returncode == 0
    while not more_sorted(14):
        yield
    assert command("stop", "latest", "--wait").returncode == 0
