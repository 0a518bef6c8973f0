"""beltsort show and beltsort explain, on a run of a cell with scripted labels."""

import csv
import json
import re
from pathlib import Path

import pytest

from beltsort.sorting.audit import steps_of
from beltsort.sorting.journal import read_journal
from beltsort.sorting.report import SortingReport
from tests.sorting.killed_run import OBJECTS, run

from .running import command, json_of, output

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def sorted_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, SortingReport]:
    folder = tmp_path_factory.mktemp("run")
    return folder, run(folder, "never", resume=False)


def test_show_tells_what_was_decided(sorted_run: tuple[Path, SortingReport]) -> None:
    folder, report = sorted_run
    text = output("show", str(folder))
    assert len(re.findall(r"^ +\d+  .* decide \w+ ", text, re.MULTILINE)) == OBJECTS
    assert text.endswith(f"10 sorted, 0 empty, 0 left; {report.steps} steps\n")
    told = json_of("show", str(folder / "journal.sqlite"))
    assert [decision["label"] for decision in told["decisions"]] == [d.label for d in report.decisions]
    assert [entry["number"] for entry in told["entries"]] == list(range(1, len(told["entries"]) + 1))


def test_a_folder_of_runs_stands_for_the_newest(
    tmp_path: Path, sorted_run: tuple[Path, SortingReport]
) -> None:
    folder, _ = sorted_run
    for name in ("2026-01-02T00-00-00Z", "2026-01-10T00-00-00Z"):
        (tmp_path / name).mkdir()
    (tmp_path / "2026-01-02T00-00-00Z" / "journal.sqlite").write_bytes(b"another")
    (tmp_path / "2026-01-10T00-00-00Z" / "journal.sqlite").write_bytes(
        (folder / "journal.sqlite").read_bytes()
    )
    assert output("show", str(tmp_path)) == output("show", str(folder))


def test_show_writes_every_entry_as_csv(tmp_path: Path, sorted_run: tuple[Path, SortingReport]) -> None:
    folder, _ = sorted_run
    done = command("show", str(folder), "--csv", str(tmp_path / "run.csv"))
    assert done.returncode == 0
    with (tmp_path / "run.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    entries = read_journal(folder / "journal.sqlite")
    assert [row["kind"] for row in rows] == [entry.kind for entry in entries]
    assert [json.loads(row["data"]) for row in rows] == [entry.data for entry in entries]


def test_explain_plans_the_same_again(sorted_run: tuple[Path, SortingReport]) -> None:
    folder, report = sorted_run
    steps = list(steps_of(read_journal(folder / "journal.sqlite")))
    assert [step.number for step in steps] == list(range(1, report.steps + 1))
    for step in steps:
        plan = step.plan_again()
        assert plan is not None
        assert plan.action == step.action
        recorded = [action["value"] for action in step.entry.data["values"]]
        assert list(plan.values.values()) == recorded
    text = output("explain", str(folder), "--step", "1")
    assert "It was chosen to move to" in text
    assert "one more look, from" in text
    assert json_of("explain", str(folder), "--step", "2")["same_again"] is True


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["show", "{folder}/none"], r"/none\b.*\bjournal\.sqlite\b"),
        (["explain", "{folder}", "--step", "0"], r"\bstep 0\b.*\b1\b.*\d"),
        (["explain", "{folder}", "--step", "9999"], r"\bstep 9999\b.*\b1\b.*\d"),
    ],
)
def test_errors_are_one_line(
    sorted_run: tuple[Path, SortingReport], arguments: list[str], message: str
) -> None:
    done = command(*(argument.format(folder=sorted_run[0]) for argument in arguments))
    assert done.returncode == 2
    assert re.fullmatch(rf"beltsort: error: .*{message}.*\n", done.stderr)


def test_explain_an_object(sorted_run: tuple[Path, SortingReport]) -> None:
    folder, report = sorted_run
    decision = report.decisions[3]
    told = json_of("explain", str(folder), "--object", str(decision.object))
    assert told["object"] == decision.object
    assert told["outcome"]["looks"] == decision.looks == len(told["looks"])
    assert told["outcome"]["belief"] == pytest.approx(max(told["looks"][-1]["belief"]))
    assert [look["step"] for look in told["looks"]] == sorted(look["step"] for look in told["looks"])
    why = told["decision_step"]
    assert why["object"] == decision.object
    assert why["belief"][0] == pytest.approx(told["looks"][-1]["belief"])
    assert why["same_again"] is True
    text = output("explain", str(folder), "--object", str(decision.object))
    assert len(re.findall(r"^ +\d+ +p\d +[12] ", text, re.MULTILINE)) == len(told["looks"])
    assert f"Decided after {decision.looks} looks: {told['outcome']['decided']}, right with" in text
    assert re.search(r"Deciding \w+ now is right with \d+ % and worth", text)


def test_an_object_that_the_run_does_not_have(sorted_run: tuple[Path, SortingReport]) -> None:
    done = command("explain", str(sorted_run[0]), "--object", "99")
    assert done.returncode == 2
    assert re.search(r"there is no object 99; the journal has objects 0 to \d+", done.stderr)
