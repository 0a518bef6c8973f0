"""How `beltsort run` ends, and what it says to whoever has to go on."""

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from beltsort import BeltsortError
from beltsort.cell import Outcome, SortInto
from beltsort.cli import code_of, exit_codes, main
from beltsort.cli.operator import CommandLineOperator
from beltsort.drivers.fieldbus import FieldbusDevice
from beltsort.errors import InUseError, JournalNotWrittenError
from beltsort.models import paper
from beltsort.sorting.command import Command
from beltsort.sorting.holds import Answer, HeldError, Hold, Way
from beltsort.sorting.journal import read_journal
from beltsort.sorting.locks import devices_locked, locked
from beltsort.sorting.progress import Progress
from tests.cli.cells import cell_file
from tests.contract.peers import ModbusPeer

pytestmark = pytest.mark.process

RECOVERY = Path(__file__).parents[2] / "docs" / "recovery.md"
MODBUS = """
[backends.modbus]
host = "127.0.0.1"
port = {port}
allow_insecure = true
"""


@pytest.fixture
def peer(tmp_path: Path) -> Iterator[ModbusPeer]:
    peer = ModbusPeer(tmp_path)
    try:
        peer.start()
        yield peer
    finally:
        peer.close()


def modbus_cell(folder: Path, peer: ModbusPeer, *changes: tuple[str, str]) -> str:
    """Return a cell file whose belt and sorter are a controller's."""
    cell = cell_file(folder, *changes)
    text = Path(cell).read_text()
    for role in ("belt", "sorter"):
        text = text.replace(f'[{role}]\nbackend = "simulated"', f'[{role}]\nbackend = "modbus"')
    Path(cell).write_text(text + MODBUS.format(port=peer.port))
    return cell


def homed(peer: ModbusPeer, index: int) -> FieldbusDevice:
    device = peer.unhomed()
    device.home(index)
    return device


def begun(cell: str, *arguments: str, **streams: Any) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "beltsort", "run", cell, *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **streams)


def the_run(folder: Path) -> Path:
    (run,) = (folder / "runs").iterdir()
    return run


def test_nothing_but_a_person_homes_a_belt(
    folder: Path, peer: ModbusPeer, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = modbus_cell(folder, peer)
    run = ["run", cell, "--objects", "2", "--live", "--json"]
    assert main(run) == exit_codes.NEEDS_PERSON
    said = capsys.readouterr().err
    assert f"beltsort home {cell} NUMBER --live && beltsort run {cell} --live" in said
    assert not peer.unhomed().health().ready
    assert main(["home", cell, "5"]) == 0
    assert not peer.unhomed().health().ready, "only with --live"
    assert main(["home", cell, "5", "--live"]) == 0
    capsys.readouterr()
    for first in (5, 7):
        assert main(run) == 0
        decisions = json.loads(capsys.readouterr().out)["decisions"]
        assert [decision["object"] for decision in decisions] == [first, first + 1]
    assert peer.push("look")["position"] == 9
    assert main([*run, "--first-object", "20"]) == 0
    assert peer.push("look")["position"] == 22


def test_a_second_run_is_refused_while_one_is_under_way(
    folder: Path, peer: ModbusPeer, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = modbus_cell(folder, peer)
    device = homed(peer, 3)
    with devices_locked([device]):
        for command in (["run", cell, "--live"], ["home", cell, "0", "--live"], ["check", cell, "--live"]):
            assert main(command) == exit_codes.IN_USE
            said = capsys.readouterr().err
            assert f"127.0.0.1:{peer.port} is in use by process {os.getpid()} " in said
    assert device.position() == 3
    device.close()


def test_a_run_under_way_is_not_resumed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell = cell_file(folder)
    assert main(["run", cell, "--objects", "1"]) == 0
    run = the_run(folder)
    with locked("the run", run / "lock"):
        assert main(["run", cell, "--resume", str(run)]) == exit_codes.IN_USE
    assert f"process {os.getpid()} " in capsys.readouterr().err
    assert main(["run", cell, "--resume", str(run)]) == 0


def test_a_lock_ends_with_its_process(tmp_path: Path) -> None:
    code = "import sys, time; from pathlib import Path; from beltsort.sorting.locks import locked\n"
    code += (
        f"with locked('it', Path({str(tmp_path / 'lock')!r})): print('locked', flush=True); time.sleep(99)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "locked\n"
        with pytest.raises(InUseError, match=rf"\bprocess {holder.pid}\b"), locked("it", tmp_path / "lock"):
            pass
        holder.kill()
    with locked("it", tmp_path / "lock"):
        pass


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_the_devices_and_leaves_a_run_that_goes_on(
    folder: Path, number: signal.Signals, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = cell_file(folder)
    with begun(cell) as run:
        assert run.stdout is not None
        assert any("decide" in line for line in run.stdout)  # no pause between lines: the run goes on
        run.send_signal(number)
        run.communicate()
    assert run.returncode == exit_codes.SIGNALLED + number
    entries = read_journal(the_run(folder) / "journal.sqlite")
    assert entries[-1].kind == "end"
    assert number.name in entries[-1].data["reason"]
    calls = [json.loads(line) for line in (the_run(folder) / "calls.jsonl").read_text().splitlines()]
    assert [call["call"]["name"] for call in calls[-4:]] == ["stop"] * 4
    assert main(["run", cell, "--resume", str(the_run(folder)), "--json"]) == 0
    decisions = json.loads(capsys.readouterr().out)["decisions"]
    assert [decision["object"] for decision in decisions] == list(range(10))


@pytest.mark.slow
def test_a_run_goes_on_when_nobody_reads_its_output(folder: Path) -> None:
    with begun(cell_file(folder)) as run:
        assert run.stdout is not None
        run.stdout.readline()
        run.stdout.close()
        assert run.stderr is not None
        said = run.stderr.read()
    assert run.returncode == 0
    assert "standard output was closed" in said
    entries = read_journal(the_run(folder) / "journal.sqlite")
    assert entries[-1].data == {"reason": "done"}
    assert sum(entry.kind == "decision" for entry in entries) == 10
    assert sum(entry.kind == "unheard" for entry in entries) == 1


def test_a_run_is_resumed_as_it_began(
    folder: Path, peer: ModbusPeer, capsys: pytest.CaptureFixture[str]
) -> None:
    """Else a rehearsal would say of a live run's objects that they were sorted."""
    cell = modbus_cell(folder, peer)
    peer.device().close()
    assert main(["run", cell, "--objects", "1", "--first-object", "0"]) == 0
    rehearsed = the_run(folder)
    assert rehearsed.name.endswith("-dry-run")
    assert main(["run", cell, "--resume", str(rehearsed), "--live"]) == exit_codes.WRONG
    assert "is a dry run" in capsys.readouterr().err
    live = rehearsed.rename(rehearsed.with_name("live"))
    assert main(["run", cell, "--resume", str(live)]) == exit_codes.WRONG
    assert re.search(r"\bis a live run\b.*\bwith --live\b", capsys.readouterr().err)


def test_an_answer_is_for_what_was_asked(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell = cell_file(folder)
    assert main(["run", cell, "--settle", "done"]) == exit_codes.WRONG
    assert main(["run", cell, "--objects", "1"]) == 0
    capsys.readouterr()
    runs = sorted((folder / "runs").iterdir())
    assert main(["run", cell, "--resume", str(runs[-1]), "--settle", "done"]) == exit_codes.WRONG
    assert re.search(r"--settle is done\b.*\bno such answer\b", capsys.readouterr().err)
    broken_off = Progress.at_start(paper())
    broken_off.index, broken_off.pending = 7, Command("5e-sort-3", SortInto(2), "boot")
    ways = (Way("if it is", Answer.DONE), Way("if not", Answer.NOT_DONE))
    operator = CommandLineOperator("done", broken_off)
    assert operator(Hold(broken_off.pending, "?", ways, object=7)) is Answer.DONE
    with pytest.raises(HeldError):
        operator(Hold(broken_off.pending, "?", ways, object=7))
    with pytest.raises(HeldError):
        CommandLineOperator("done", broken_off)(Hold(broken_off.pending, "?", ways, object=12))
    broken_off.known_outcome = Outcome.NOT_DONE
    with pytest.raises(BeltsortError, match=r"\bgiven already\b"):
        CommandLineOperator("not-done", broken_off)


@pytest.mark.slow
def test_the_result_is_told_although_nobody_reads_the_rest(folder: Path) -> None:
    with begun(cell_file(folder), "--objects", "2", "--json") as run:
        assert run.stderr is not None
        run.stderr.readline()
        run.stderr.close()
        assert run.stdout is not None
        result = json.loads(run.stdout.read())
    assert run.returncode == 0
    assert len(result["decisions"]) == 2


def test_a_pressed_emergency_stop_is_told_apart(
    folder: Path, peer: ModbusPeer, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = modbus_cell(folder, peer)
    homed(peer, 0).close()
    peer.push("press")
    assert main(["run", cell, "--objects", "1", "--live"]) == exit_codes.EMERGENCY_STOP
    peer.push("release")
    assert main(["run", cell, "--objects", "1", "--live"]) == 0
    peer.kill()
    assert main(["run", cell, "--objects", "1", "--live"]) == exit_codes.TRY_AGAIN
    assert "cannot be asked" in capsys.readouterr().err


def test_exit_codes_are_the_documented_ones() -> None:
    rows = re.findall(r"^\| ([\d, ]+) \| (.+) \|$", RECOVERY.read_text(), re.MULTILINE)
    documented = {int(number) for numbers, _ in rows for number in numbers.split(",")}
    single = {value for name, value in vars(exit_codes).items() if name.isupper()} - {exit_codes.SIGNALLED}
    signals = {exit_codes.SIGNALLED + number for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM)}
    assert documented == single | signals
    assert code_of(JournalNotWrittenError("full")) == exit_codes.NOT_WRITTEN
    assert code_of(BeltsortError("wrong")) == exit_codes.WRONG
