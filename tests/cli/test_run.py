"""`beltsort run`, with a classifier of a few objects and a model made up for it."""

import dataclasses
import json
import re
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort.cellfile.registry import BUILT_IN
from beltsort.cellfile.simulated import BACKEND
from beltsort.cli import exit_codes, main
from beltsort.perception import LabelRule, NearestNeighbour
from beltsort.sim import CellConfig
from beltsort.sim.prepare import Prepared, Recipe
from beltsort.sorting.journal import entries_after, read_journal
from beltsort.sorting.kept_scans import KeptScan, kept_scans, scan_file
from beltsort.sorting.progress import Progress
from beltsort.sorting.requests import TOKEN, Request, read_token, write_request
from beltsort.sorting.runs import read_true_classes
from beltsort.tables.counts import Look, count
from tests.cellfile.cell_files import changed
from tests.cli.cells import PREPARE, cell_file
from tests.cli.running import process, result_of
from tests.contract.peers import OpcuaPeer

pytestmark = pytest.mark.process

REAL = dataclasses.replace(BACKEND, harmless=False)
"""The simulated cell, taken for a real one."""

FULL_BIN = (
    "[planner]",
    "[rules]\nretry_delays = [0.0, 0.0]\n[faults]\nschedule = ["
    + ", ".join(f'{{command = "sort", number = {n}, kind = "full_bin"}}' for n in (1, 2, 3))
    + "]\n[planner]",
)
"""A change of the cell file: the sorter's bin is full as often as the first sort is tried."""


def test_a_run_sorts_every_object_and_keeps_its_record(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ending = cell_file(folder, ("version = 1", "version = 1\nbelt_ends = true"))
    assert main(["run", ending, "--objects", "2"]) == 0
    said = capsys.readouterr().out
    assert "sorting 2 objects: elongated, livarno, mushroom, standard" in said
    assert "2 sorted in " in said
    (run,) = (folder / "runs").iterdir()
    assert not run.name.endswith("dry-run")
    entries = read_journal(run / "journal.sqlite")
    assert entries[0].data["belt_ends"]
    assert entries[-1].data == {"reason": "done"}
    calls = [json.loads(line) for line in (run / "calls.jsonl").read_text().splitlines()]
    asked = [(call["device"], call["call"]["name"]) for call in calls[:6]]
    assert asked[:2] == [("belt", "position"), ("belt", "health")]
    assert asked[2:] == [(device, "health") for device in ("arm", "camera", "belt", "sorter")]
    done = {e.data["command_id"] for e in entries if e.kind == "outcome"}
    assert {call["call"]["command_id"] for call in calls if call["call"]["command_id"]} == done
    assert beltsort.SortingModel.load(run / "model.json").positions == 2


def test_a_run_can_be_held_and_continued(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = cell_file(folder)
    answered: list[str] = []

    def person() -> None:
        while not (tokens := list(folder.glob(f"runs/*/{TOKEN}"))) or not read_token(tokens[0].parent):
            time.sleep(0.01)
        run = tokens[0].parent
        answered.append(run.name)
        write_request(run, Request.now("hold", "test"))
        while "request" not in [entry.kind for entry in entries_after(run / "journal.sqlite", 0)]:
            time.sleep(0.05)
        write_request(run, Request.now("continue", "test"))

    thread = threading.Thread(target=person)
    thread.start()
    assert main(["run", path, "--objects", "2", "--allow-hold"]) == 0
    thread.join()
    said = capsys.readouterr().out
    assert f"beltsort watch runs/{answered[0]} --control" in said
    assert "asked to hold" in said
    assert "2 sorted in " in said
    run = folder / "runs" / answered[0]
    assert not (run / TOKEN).exists()
    assert read_true_classes(run).keys() == {0, 1}
    assert KeptScan.load(scan_file(run, kept_scans(run)[-1])).layout.positions == 2


def test_json_is_one_object_and_the_same_seed_gives_the_same_run(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = cell_file(folder, ("\nobjects = 10\n", "\nobjects = 3\n"))
    results = []
    for _ in range(2):
        assert main(["run", path, "--json"]) == 0
        results.append(result_of(capsys))
    first, again = results
    assert [d["object"] for d in first["decisions"]] == [0, 1, 2]
    assert first["decisions"] == again["decisions"]
    assert first["folder"] != again["folder"]
    assert first["dry_run"] == []


def test_true_labels_may_be_given_and_cups_empty(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    labels = ('draw_from = ["elongated", "livarno"]', 'true_labels = ["standard", "-"]')
    assert main(["run", cell_file(folder, labels), "--objects", "3", "--json"]) == 0
    result = result_of(capsys)
    assert [d["object"] for d in result["decisions"]] == [0]
    assert result["skipped"] == [1, 2], "behind the last object all cups are empty"


def test_bins_need_not_be_the_classes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two bins for four classes, and one for a person."""
    path = folder / "cell" / "model.json"
    reward = [[10, 10, -20, -20], [-20, -20, 10, 10], [-1, -1, -1, -1]]
    bins, old = ["long", "round", "by hand"], beltsort.SortingModel.load(path)
    sets = (old.classes, old.viewpoints, old.p_obs)
    beltsort.SortingModel(*sets, bins=bins, reward=reward).save(path)
    objects = ("\nobjects = 10\n", '\nobjects = 3\nbins = {long = 0, "by hand" = 2, round = 1}\n')
    assert main(["run", cell_file(folder, objects), "--json"]) == 0
    said = capsys.readouterr()
    assert "sorting 3 objects: elongated, livarno, mushroom, standard, into long, round, by hand" in said.err
    result = json.loads(said.out)
    decided = Counter(d["decided"] for d in result["decisions"])
    assert result["bins"] == decided
    assert [sum(row) for row in result["confusion"]] == [decided[name] for name in bins]
    assert sum(map(sum, result["confusion"])) == 3
    (long, round_, by_hand), (elongated, livarno, mushroom, standard) = bins, range(4)
    belonging = {long: [elongated, livarno], round_: [mushroom, standard], by_hand: []}
    right = {
        name: sum(counts[c] for c in belonging[name])
        for name, counts in zip(bins, result["confusion"], strict=True)
    }
    assert result["correct"] == sum(right.values())
    assert result["purity"] == {
        name: right[name] / decided[name] if decided[name] and belonging[name] else None for name in bins
    }
    assert main(["show", result["folder"], "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)["decisions"]
    assert [d["decided"] for d in shown] == [d["decided"] for d in result["decisions"]]
    for command in (["run", cell_file(folder), "--objects", "1"], ["check", cell_file(folder)]):
        assert main(command) == exit_codes.WRONG
        assert "bins: is missing" in capsys.readouterr().err


def test_a_models_rule_makes_its_labels(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "cell" / "model.json"
    old = beltsort.SortingModel.load(path)
    rule = LabelRule(tuple(old.classes), (0.1,))
    p_obs = np.repeat(old.p_obs, 2, axis=-1) / 2.0
    model = beltsort.SortingModel(old.classes, old.viewpoints, p_obs, labels=rule.labels)
    model.replace(label_rule=rule.to_dict()).save(path)
    assert main(["run", cell_file(folder), "--objects", "2"]) == 0
    assert re.search(r"look from p\d: \w+, (un)?sure \| ", capsys.readouterr().out)
    model.save(path)
    assert main(["run", cell_file(folder), "--objects", "2"]) == exit_codes.WRONG
    assert "cannot give ['elongated, unsure', " in capsys.readouterr().err


def test_without_live_nothing_real_moves(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = dict.fromkeys(BUILT_IN["simulated"], "tests.cli.test_run:REAL")
    monkeypatch.setitem(BUILT_IN, "real", real)
    path = cell_file(folder, ('"simulated"', '"real"'), ("[backends.simulated]", "[backends.real]"))
    assert main(["run", path, "--objects", "1"]) == 0
    said = capsys.readouterr().out
    assert "dry run: arm, belt, sorter " in said
    assert re.search(r"dry run: move_to\(0\), \w{8}-move-1", said)
    assert "dry run: advance_to(1)" in said
    (run,) = (folder / "runs").iterdir()
    assert run.name.endswith("-dry-run")
    assert main(["check", path, "--live", "--json"]) == 0
    assert result_of(capsys)["dry_run"] == []


def test_a_failing_command_ends_the_run_and_stops_the_devices(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", cell_file(folder, FULL_BIN), "--objects", "2"]) == exit_codes.TRY_AGAIN
    said = capsys.readouterr()
    assert re.search(r"held at sort \d\b.*\b3 times\b.*\bfull\b", said.err)
    assert "bin full" in said.out
    assert "remove [faults] from the cell file" in said.out
    (run,) = (folder / "runs").iterdir()
    assert "HeldError" in read_journal(run / "journal.sqlite")[-1].data["reason"]
    calls = [json.loads(line) for line in (run / "calls.jsonl").read_text().splitlines()]
    assert [call["call"]["name"] for call in calls[-4:]] == ["stop"] * 4
    assert sum("full" in (call["error"] or "") for call in calls) == 3


def test_a_classifier_of_other_classes_is_refused_before_anything_moves(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    order = ('"mushroom", "standard"', '"standard", "mushroom"')
    assert main(["run", cell_file(folder, order)]) == 2
    said = capsys.readouterr().err
    assert re.search(r"classifier: .*\['elongated', 'livarno', 'mushroom', 'standard'\]", said)
    assert list((folder / "runs").iterdir()) == []


def test_files_that_are_missing_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "cell" / "classifier.npz").unlink()
    assert main(["run", cell_file(folder)]) == 2
    assert "cell/classifier.npz" in capsys.readouterr().err


def test_every_problem_of_a_file_is_one_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = cell_file(folder, ("spacing", "spacng"), ("trials = 20", "trials = 0"))
    for name in ("run", "check"):
        assert main([name, path]) == 2
        first, *problems = capsys.readouterr().err.splitlines()
        assert re.search(r"\bcell\.toml\b", first)
        assert [problem.split(":")[0] for problem in problems] == ["belt.spacng", "planner.trials"]


def test_a_senseless_number_of_objects_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", cell_file(folder), "--objects", "0"]) == 2
    assert re.search(r"--objects\b.*\b0\b.*\b1\b", capsys.readouterr().err)


def test_a_cell_prepares_itself(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []

    def prepare(recipe: Recipe, **_: Any) -> Prepared:
        asked.append(recipe)
        looks = [Look(j, k, c, c) for j in range(2) for k in range(3) for c in range(4) for _ in range(20)]
        database = NearestNeighbour.load(folder / "cell" / "classifier.npz")
        return Prepared(database, count(looks, 2, 3, 4), 20, {}, "cache")

    monkeypatch.setattr("beltsort.cellfile.ingredients.prepare", prepare)
    path = str(changed(folder, (PREPARE, PREPARE.replace("40", "7"))))
    assert main(["run", path, "--objects", "1", "--json"]) == 0
    assert len(result_of(capsys)["decisions"]) == 1
    assert asked == [Recipe(training_objects=7)], "as the demo's but for what the file says"


def test_only_a_simulated_cell_prepares_itself(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(changed(folder, ('[sorter]\nbackend = "simulated"', '[sorter]\nbackend = "dry-run"')))
    assert main(["run", path]) == 2
    assert re.search(r"\bprepare: .*\bsorter\b.*\bsimulated\b", capsys.readouterr().err)


def test_help_of_the_real_command() -> None:
    for name in ("run", "check"):
        assert "docs/cell.md" in process(name, "--help").stdout


def test_a_held_run_goes_on_when_it_is_resumed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", cell_file(folder, FULL_BIN), "--objects", "2"]) == exit_codes.TRY_AGAIN
    (run,) = (folder / "runs").iterdir()
    capsys.readouterr()
    whole = cell_file(folder)
    assert main(["run", whole, "--resume", str(run), "--json"]) == 0
    assert [decision["object"] for decision in result_of(capsys)["decisions"]] == [0, 1]
    assert main(["run", whole, "--resume", str(folder / "none")]) == 2
    assert re.search(r"/none/journal\.sqlite\b", capsys.readouterr().err)


def test_an_arm_that_arrives_elsewhere_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fault = '[faults]\nschedule = [{command = "move_to", number = 2, kind = "wrong_arrival"}]\n[planner]'
    assert main(["run", cell_file(folder, ("[planner]", fault)), "--objects", "1"]) == 0
    assert re.search(r"wrong viewpoint: .*\bp\d\b", capsys.readouterr().out)
    (run,) = (folder / "runs").iterdir()
    assert main(["explain", str(run), "--step", "1"]) == 0
    assert "While it was carried out:\n  object  0  wrong viewpoint: " in capsys.readouterr().out
    assert main(["explain", str(run), "--step", "1", "--json"]) == 0
    assert [mishap["kind"] for mishap in result_of(capsys)["befell"]] == ["wrong_viewpoint"]


def test_tables_that_do_not_hold_are_told_and_hold_the_run(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sure, standard = np.tile(0.01 + 0.96 * np.eye(4), (2, 3, 1, 1)), [0.01, 0.01, 0.01, 0.97]
    model = beltsort.SortingModel(CellConfig().classes, ["p1", "p2", "p3"], sure, arrival=standard, r_min=500)
    model.save(folder / "cell" / "model.json")
    drift = "[drift]\nfalse_alarm = 0.2\nhold = true\n[planner]"
    assert main(["run", cell_file(folder, ("[planner]", drift))]) == exit_codes.NEEDS_PERSON
    said = capsys.readouterr()
    assert "warning: labels" in said.out
    assert re.search(r"\d drift alarms\b.*\bdrift\.hold\b", said.err)
    (run,) = (folder / "runs").iterdir()
    told = cell_file(folder, ("[planner]", drift.replace("hold = true", "")))
    assert main(["run", told, "--resume", str(run), "--json"]) == 0
    alarms = result_of(capsys)["drift"]
    assert alarms
    assert main(["show", str(run)]) == 0
    assert f"{len(alarms)} drift alarms: " in capsys.readouterr().out
    assert main(["show", str(run), "--json"]) == 0
    assert result_of(capsys)["drift"] == alarms
    last = str(Progress.after(read_journal(run / "journal.sqlite")).steps)
    assert main(["explain", str(run), "--step", last]) == 0
    assert f"After {len(alarms)} drift alarms: " in capsys.readouterr().out


def test_belt_and_sorter_over_opc_ua(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    peer = OpcuaPeer(folder)
    try:
        peer.start("--home", "0")
        client, cell = peer.client, cell_file(folder)
        options = f"""
            [backends.opcua]
            endpoint = "opc.tcp://127.0.0.1:{peer.port}/beltsort"
            certificate = "{client.certificate}"
            private_key = "{client.private_key}"
            trust = "{client.trust}"
        """
        text = Path(cell).read_text()
        for role in ("belt", "sorter"):
            text = text.replace(f'[{role}]\nbackend = "simulated"', f'[{role}]\nbackend = "opcua"')
        Path(cell).write_text(text + "\n".join(line.strip() for line in options.splitlines()))
        assert main(["run", cell, "--objects", "3", "--json"]) == 0
        assert result_of(capsys)["dry_run"] == ["belt", "sorter"]
        assert peer.push("look")["bins"] == [0] * 5
        for first in (0, 3):  # a second run goes on where the belt stands
            assert main(["run", cell, "--objects", "3", "--live", "--json"]) == 0
            decisions = result_of(capsys)["decisions"]
            assert [decision["object"] for decision in decisions] == [first, first + 1, first + 2]
        seen = peer.push("look")
        assert sum(seen["bins"]) == 6
        assert seen["position"] == 6
    finally:
        peer.close()
