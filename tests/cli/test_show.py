"""beltsort show and beltsort explain, on a run of a cell with scripted labels."""

import csv
import json
import re
from pathlib import Path

import pytest

from beltsort import Decide
from beltsort.cli.explain import show_run
from beltsort.errors import JournalError
from beltsort.sorting.audit import steps_of
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.object_history import object_history
from beltsort.sorting.record import progress_in
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


def test_show_numbers_looks_and_decisions_by_planner_step(sorted_run: tuple[Path, SortingReport]) -> None:
    folder, report = sorted_run
    text = output("show", str(folder))
    numbered = re.findall(r"^ +(\d+)  .*object +\d+  (look|decide) ", text, re.MULTILINE)
    assert [int(number) for number, _ in numbered] == list(range(1, report.steps + 1))
    actions = [step.action for step in steps_of(read_journal(folder / "journal.sqlite"))]
    assert [what == "decide" for _, what in numbered] == [isinstance(action, Decide) for action in actions]
    told = json_of("show", str(folder))["entries"]
    assert [e["step"] for e in told if e["kind"] in ("scan", "decision")] == [int(n) for n, _ in numbered]
    assert {e["step"] for e in told if e["kind"] not in ("scan", "decision")} == {None}


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
    assert f"the run sorts {OBJECTS} objects, numbered 0 to {OBJECTS - 1}" in done.stderr


def test_explain_says_what_can_be_explained(sorted_run: tuple[Path, SortingReport]) -> None:
    folder, report = sorted_run
    text = output("explain", str(folder))
    assert text.startswith("The run sorts 10 objects, numbered 0 to 9.\n  decided: 0 to 9\n")
    assert f"Its planner steps are 1 to {report.steps}.\n" in text
    assert text.endswith(output("explain", str(folder), "--object", "9"))
    told = json_of("explain", str(folder))
    assert (told["objects"], told["decided"], told["last_decided"]) == (10, list(range(10)), 9)
    assert told["steps"] == list(range(1, report.steps + 1))


def test_an_object_behind_the_last_one(sorted_run: tuple[Path, SortingReport]) -> None:
    text = output("explain", str(sorted_run[0]), "--object", str(OBJECTS))
    assert "It is behind the last object of this run, which sorts 10 objects, numbered 0 to 9" in text


def test_an_object_that_is_undecided(sorted_run: tuple[Path, SortingReport]) -> None:
    entries = read_journal(sorted_run[0] / "journal.sqlite")
    first = next(i for i, entry in enumerate(entries) if entry.kind == "scan")
    begun = entries[: first + 1]
    assert object_history(begun, 0).undecided == "It has not been decided: it is at the belt end."
    behind = object_history(begun, 1).undecided
    assert behind == "It has not been decided: it is at position 2, object 0 at the belt end."
    with pytest.raises(JournalError, match=r"no object 5; .* not been seen yet, object 0 is at the belt end"):
        object_history(begun, 5)


def test_before_the_first_step(
    sorted_run: tuple[Path, SortingReport], capsys: pytest.CaptureFixture[str]
) -> None:
    show_run(read_journal(sorted_run[0] / "journal.sqlite")[:2], depth=1)
    assert capsys.readouterr().out.splitlines() == [
        "The run sorts 10 objects, numbered 0 to 9.",
        "  at the belt end: 0",
        "It has taken no planner step yet.",
    ]


def test_after_the_last_decision_no_object_is_left(sorted_run: tuple[Path, SortingReport]) -> None:
    text = output("explain", str(sorted_run[0]), "--object", str(OBJECTS - 1))
    assert text.endswith("', most likely:\n  no object is left\n")


def test_an_object_of_an_earlier_file(sorted_run: tuple[Path, SortingReport], tmp_path: Path) -> None:
    journal = tmp_path / "journal.sqlite"
    journal.write_bytes((sorted_run[0] / "journal.sqlite").read_bytes())
    with Journal(journal, resume=True, keep=1) as open_journal:
        for _ in range(2):
            open_journal.rotate(progress_in(journal).snapshot())
    with pytest.raises(JournalError, match=r"no object 2; .* left the belt before the oldest entry"):
        object_history(read_journal(journal), 2)
