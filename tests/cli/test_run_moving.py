"""`beltsort run` with a belt that never stops, and what reads such runs."""

import json
import threading
from collections import Counter
from pathlib import Path

import pytest

import beltsort
from beltsort.cli import exit_codes, main
from beltsort.sim.prepare import CLASSIFIER, PACKAGED
from beltsort.sorting.journal import entries_after, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.moving.entries import Diverting, Fate, Looked, ObjectLeft
from beltsort.sorting.requests import Request, read_token, write_request
from beltsort.watch import Watcher
from tests.cellfile.test_moving import changed
from tests.cli.cells import PREPARE
from tests.cli.running import result_of
from tests.contract.peers import ModbusPeer
from tests.waiting import wait_until

pytestmark = pytest.mark.process

FEW_SLICES = ("exposure = 0.03", "exposure = 0.0")


@pytest.fixture
def cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return a cell file in the working folder."""
    monkeypatch.chdir(tmp_path)
    return str(changed(tmp_path, FEW_SLICES, ("trials = 10", "trials = 2")))


def test_a_run_sorts_accounts_for_every_object_and_can_be_read(
    cell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", cell, "--objects", "3", "--json"]) == 0
    said = capsys.readouterr()
    assert "sorting 3 objects on a belt that never stops" in said.err
    assert "3 objects in " in said.err
    result = json.loads(said.out)
    assert result["objects"] == sum(result["fates"].values()) == 3
    assert result["correct"] <= sum(result["bins"].values()) == result["fates"]["in bin"] >= 1
    assert [sum(row) for row in result["confusion"]] == list(result["bins"].values())
    assert (result["dry_run"], result["stopped_by"]) == ([], None)
    run = Path(result["folder"])
    entries = read_journal(run / JOURNAL)
    assert entries[0].kind == "moving_start"
    assert entries[-1].data == {"reason": "done"}
    calls = [json.loads(line) for line in (run / "calls.jsonl").read_text().splitlines()]
    asked = [(call["device"], call["call"]["name"]) for call in calls]
    assert asked[:3] == [(device, "health") for device in ("arm", "camera", "belt")]
    assert {name for device, name in asked if device == "belt"} >= {"reading", "divert", "diversion"}

    assert main(["status", "latest", "--json"]) == 0
    status = result_of(capsys)
    assert (status["condition"], status["left"], status["fates"]) == ("finished", 0, result["fates"])
    assert (status["object"], status["steps"], status["next"]) == (3, result["scans"], [])
    assert main(["status", "latest"]) == 0
    said_of_it = capsys.readouterr().out
    assert "object 3 is the first undecided one, 0 of 3 left" in said_of_it
    for fate, number in result["fates"].items():
        assert (f"{number} {fate}" in said_of_it) == (number > 0 and fate != Fate.IN_BIN)
    assert main(["show", "latest", "--json"]) == 0
    shown = result_of(capsys)
    assert (shown["fates"], shown["left_belt"], len(shown["entries"])) == (result["fates"], 3, len(entries))
    assert main(["show", "latest"]) == 0
    lines = capsys.readouterr().out
    for left in (entry.content for entry in entries):
        if isinstance(left, ObjectLeft) and left.fate is Fate.IN_BIN:
            assert f"object {left.number:>2}  in bin " in lines

    watched = Watcher(run).state().run
    assert (watched.state, watched.moment.left, watched.moment.tally.fates) == (
        "Complete",
        3,
        result["fates"],
    )
    for other in (["explain", "latest"], ["run", cell, "--resume", "latest"]):
        assert main(other) == exit_codes.WRONG
        message = capsys.readouterr().err
        assert "belt that never stops" in message or "is finished" in message


def test_a_run_that_was_stopped_is_resumed_where_it_was(
    cell: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop_after_a_decision() -> None:
        runs = tmp_path / "runs"
        run = wait_until(lambda: next((each for each in runs.glob("*") if read_token(each)), None), "a run")
        journal = run / JOURNAL
        wait_until(lambda: "divert" in [entry.kind for entry in entries_after(journal, 0)], "a decision")
        write_request(run, Request.now("stop", "test"))

    thread = threading.Thread(target=stop_after_a_decision)
    thread.start()
    assert main(["run", cell, "--objects", "8", "--allow-hold", "--json"]) == 0
    thread.join()
    said = capsys.readouterr()
    stopped = json.loads(said.out)
    assert stopped["stopped_by"] is not None
    assert "the belt stands" in said.err
    assert "beltsort: to resume: beltsort run" in said.err
    assert main(["status", "latest", "--json"]) == 0
    assert result_of(capsys)["condition"] == "stopped"
    assert main(["run", cell, "--resume", "latest", "--json"]) == 0
    result = result_of(capsys)
    assert result["folder"] == stopped["folder"]
    contents = [entry.content for entry in read_journal(Path(result["folder"]) / JOURNAL)]
    left = Counter(each.number for each in contents if isinstance(each, ObjectLeft))
    assert left == dict.fromkeys(range(8), 1)
    assert result["fates"]["lost"] == result["fates"]["unknown"] == result["fates"]["not done"] == 0
    assert len({each.number for each in contents if isinstance(each, Diverting)}) == result["fates"]["in bin"]
    travels = [each.travel for each in contents if isinstance(each, Looked)]
    assert travels == sorted(travels)


@pytest.mark.parametrize(
    "option",
    [["--rrd", "run.rrd"], ["--first-object", "3"], ["--settle", "done"], ["--policy", "threshold:0.9"]],
)
def test_options_for_belts_that_stop_are_refused(
    cell: str, option: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", cell, *option]) == exit_codes.WRONG
    assert option[1] in capsys.readouterr().err


def test_a_cell_is_checked_and_its_belt_is_not_homed(cell: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["check", cell, "--json"])  # what stands at the positions is chance
    found = result_of(capsys)
    assert list(found["health"]) == ["arm", "camera", "belt"]
    assert [view["viewpoint"] for view in found["viewpoints"]] == ["p1", "p2", "p3"]
    assert main(["home", cell, "3"]) == exit_codes.WRONG
    assert "never stops" in capsys.readouterr().err


def test_a_controller_is_tried_with_a_simulated_camera_in_real_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    beltsort.models.paper().save(tmp_path / "model.json")
    (tmp_path / "classifier.npz").write_bytes((PACKAGED / CLASSIFIER).read_bytes())
    peer, ended = ModbusPeer(tmp_path / "server"), tmp_path / "ended.jsonl"
    options = f'options = {{host = "127.0.0.1", port = {peer.port}, allow_insecure = true}}'
    cell = changed(
        tmp_path,
        FEW_SLICES,
        (PREPARE, 'model = "model.json"\nclassifier = "classifier.npz"'),
        ('[belt]\nbackend = "simulated"', f'[belt]\nbackend = "modbus"\n{options}'),
        ("ticks_per_place = 12", "ticks_per_place = 6"),
    )
    belt = ("--diverters", "0.2,0.25,0.3,0.35", "--belt-speed", "0.06", "--ended", str(ended))
    peer.start(*belt)
    try:
        assert main(["run", str(cell), "--objects", "2", "--json"]) == 0
        dry = result_of(capsys)
        assert dry["dry_run"] == ["belt"]
        assert dry["folder"].endswith("-dry-run")
        assert not ended.exists()
        assert main(["run", str(cell), "--live", "--objects", "3", "--json"]) == 0
        result = result_of(capsys)
    finally:
        peer.close()
    assert sum(result["fates"].values()) == 3
    done = [json.loads(line) for line in ended.read_text().splitlines()] if ended.exists() else []
    in_bins = Counter(each["bin"] for each in done if each["phase"] == "DONE")
    assert [in_bins[bin] for bin in range(4)] == list(result["bins"].values())
    assert sum(map(sum, result["confusion"])) == result["fates"]["in bin"]
