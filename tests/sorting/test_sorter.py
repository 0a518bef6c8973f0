import itertools
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort import Belief, Decide, Move
from beltsort.errors import CellError
from beltsort.planning.policy import Policy
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Rules
from tests.core.policies import Recorded
from tests.sorting.scripted_cell import EMPTY, UNUSABLE, Glimpse, ScriptedCell, scripted

PAPER = beltsort.SortingModel.load("tests/fixtures/paper.json")


def changed(**settings: Any) -> beltsort.SortingModel:
    """The paper's model with other settings."""
    return beltsort.SortingModel(PAPER.classes, PAPER.viewpoints, PAPER.p_obs, **settings)


def with_empty() -> beltsort.SortingModel:
    """Two classes of objects and one for empty cups, which are told apart with probability 0.8."""
    table = np.full((3, 3), 0.1) + 0.7 * np.eye(3)
    return beltsort.SortingModel(
        ["nut", "bolt", "none"], ["v", "w"], np.tile(table, (2, 2, 1, 1)), empty="none"
    )


class AlwaysLook:
    """A policy that never decides."""

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        return Move(0)


class LookOnceEach:
    """Looks once from each viewpoint in turn, then decides the most likely class."""

    def __init__(self) -> None:
        self.next = 0

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        self.next = (self.next + 1) % 2
        return Move(1) if self.next else Decide(belief.most_likely(0)[0])


def run(
    tmp_path: Path,
    cell: ScriptedCell,
    scans: Iterable[Sequence[Glimpse] | str],
    policy: Policy,
    objects: int,
    rules: Rules | None = None,
    belt_ends: bool = False,
) -> tuple[SortingReport, list[Entry]]:
    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        report = sort_objects(
            cell,
            scripted(scans),
            policy,
            cell.model,
            journal,
            objects=objects,
            belt_ends=belt_ends,
            rules=rules,
        )
    return report, read_journal(path)


def test_sorts_every_object_once_and_in_order(tmp_path: Path) -> None:
    cell = ScriptedCell(PAPER)
    report, entries = run(tmp_path, cell, itertools.repeat([1, 0]), LookOnceEach(), objects=4)
    assert [d.object for d in report.decisions] == [0, 1, 2, 3]
    assert [target for name, target in cell.acts if name == "advance"] == [1, 2, 3, 4]
    assert sum(name == "sort" for name, _ in cell.acts) == 4
    assert report.steps == 8
    assert len(set(cell.command_ids)) == len(cell.command_ids)
    assert entries[-1].kind == "end"
    assert entries[-1].data["reason"] == "done"


def test_belief_follows_bayes_and_the_belt(tmp_path: Path) -> None:
    _, entries = run(tmp_path, ScriptedCell(PAPER), [[1, 0], [2, 2]], LookOnceEach(), objects=2)
    belief = Belief(PAPER)
    belief.observe(1, [1, 0])
    scans = [entry for entry in entries if entry.kind == "scan"]
    np.testing.assert_allclose(scans[0].data["belief"], belief.probabilities, rtol=0, atol=0)
    belief.advance()
    belief.observe(1, [2, 2])
    np.testing.assert_allclose(scans[1].data["belief"], belief.probabilities, rtol=0, atol=0)


def test_the_journal_names_the_finding_at_every_position(tmp_path: Path) -> None:
    _, entries = run(tmp_path, ScriptedCell(PAPER), [[1, EMPTY]], LookOnceEach(), objects=1)
    scan = next(entry.data for entry in entries if entry.kind == "scan")
    assert scan["findings"] == ["object", "empty"]


def test_looks_count_from_the_first_sight(tmp_path: Path) -> None:
    report, _ = run(tmp_path, ScriptedCell(PAPER), itertools.repeat([1, 1]), LookOnceEach(), objects=3)
    assert [d.looks for d in report.decisions] == [1, 2, 2]


@pytest.mark.parametrize("reject_bin", [None, 7])
def test_looking_ends_at_max_looks(tmp_path: Path, reject_bin: int | None) -> None:
    cell = ScriptedCell(PAPER, reject_bin=reject_bin)
    rules = Rules(max_looks=5)
    report, _ = run(tmp_path, cell, itertools.repeat([None, None]), AlwaysLook(), 2, rules)
    assert [(d.looks, d.forced) for d in report.decisions] == [(5, "max_looks")] * 2
    assert [d.label for d in report.decisions] == [None if reject_bin else 0] * 2
    assert [target for name, target in cell.acts if name == "sort"] == [reject_bin or 0] * 2


def test_empty_place_is_confirmed_from_elsewhere_then_skipped(tmp_path: Path) -> None:
    cell = ScriptedCell(PAPER)
    scans: list[Sequence[Glimpse] | str] = [[EMPTY, 1], [EMPTY, 1], [1, None]]
    report, entries = run(tmp_path, cell, scans, LookOnceEach(), objects=2)
    assert report.skipped == (0,)
    assert [d.object for d in report.decisions] == [1]
    skip = next(entry for entry in entries if entry.kind == "skip")
    assert len(set(skip.data["viewpoints"])) == 2
    assert cell.acts.count(("sort", 1)) == 1


def test_emptiness_seen_upstream_is_confirmed_from_elsewhere(tmp_path: Path) -> None:
    # Seen empty twice from p1 on its way; only a look from another viewpoint settles it.
    rules = Rules(max_looks=3)
    hidden: list[Sequence[Glimpse] | str] = [[1, EMPTY], [1, EMPTY], [1, EMPTY], [2, None], *[[2, None]] * 3]
    cell = ScriptedCell(PAPER)
    report, _ = run(tmp_path, cell, hidden, AlwaysLook(), objects=2, rules=rules)
    assert report.skipped == ()
    assert [(d.object, d.looks) for d in report.decisions] == [(0, 3), (1, 4)]


def test_emptiness_seen_upstream_counts(tmp_path: Path) -> None:
    rules = Rules(max_looks=1)
    report, entries = run(
        tmp_path, ScriptedCell(PAPER), [[1, EMPTY], [EMPTY, None]], AlwaysLook(), objects=2, rules=rules
    )
    assert report.skipped == (1,)
    assert next(e for e in entries if e.kind == "skip").data["viewpoints"] == [0, 1]


@pytest.mark.parametrize("action", [None, "Decide(0)", Move(2), Decide(4)])
def test_illegal_actions_are_refused_before_anything_moves(tmp_path: Path, action: object) -> None:
    class Stubborn:
        def act(self, belief: Belief, viewpoint: int) -> Any:
            return action

    cell = ScriptedCell(changed(travel=[[0, 1], [0, 1, 2], [1, 2]]))
    with pytest.raises(beltsort.PolicyError, match=rf"policy\b.* {re.escape(repr(action))}"):
        run(tmp_path, cell, [], Stubborn(), objects=1)
    assert cell.acts == [("move", 0)], "only the start"


def test_an_object_that_shows_again_is_not_empty(tmp_path: Path) -> None:
    scans: list[Sequence[Glimpse] | str] = [[EMPTY, None], [2, None]]
    report, _ = run(tmp_path, ScriptedCell(PAPER), scans, LookOnceEach(), objects=1)
    assert report.skipped == ()
    assert [(d.object, d.looks) for d in report.decisions] == [(0, 2)]


def test_impossible_labels_are_dropped_and_end_the_looking(tmp_path: Path) -> None:
    # From p1, elongated at the belt end is never seen as mushroom.
    cell = ScriptedCell(changed(arrival=[1.0, 0.0, 0.0, 0.0]))
    report, entries = run(tmp_path, cell, itertools.repeat([2, None]), AlwaysLook(), objects=1)
    assert [(d.label, d.looks, d.forced) for d in report.decisions] == [(0, 3, "impossible_labels")]
    dropped = [entry.data["dropped"] for entry in entries if entry.kind == "scan"]
    assert dropped == [[{"position": 0, "label": 2, "probability": 0.0}]] * 3


def test_unusable_scans_are_repeated_then_reported(tmp_path: Path) -> None:
    scans: list[Sequence[Glimpse] | str] = [UNUSABLE, [1, None], UNUSABLE, UNUSABLE, UNUSABLE]
    with pytest.raises(HeldError, match=r"\b3 scans\b.*\bunusable\b"):
        run(tmp_path, ScriptedCell(PAPER), scans, LookOnceEach(), objects=2)
    entries = read_journal(tmp_path / "journal.sqlite")
    assert sum(entry.kind == "bad_scan" for entry in entries) == 4
    assert "HeldError" in entries[-1].data["reason"]


@pytest.mark.parametrize("call", range(1, 7))
def test_interrupt_leaves_a_complete_journal(tmp_path: Path, call: int) -> None:
    cell = ScriptedCell(PAPER, interrupt_at=call)
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, cell, itertools.repeat([1, 1]), LookOnceEach(), objects=3)
    entries = read_journal(tmp_path / "journal.sqlite")
    assert entries[-1].kind == "end"
    assert "KeyboardInterrupt" in entries[-1].data["reason"]
    intents = {e.data["command"]["id"] for e in entries if e.kind == "intent"}
    outcomes = [e.data for e in entries if e.kind == "outcome"]
    assert intents == {o["command_id"] for o in outcomes}
    assert [o["outcome"] for o in outcomes] == ["done"] * call + ["unknown"]
    assert cell.stops == 4, "every device"
    assert entries[-2].data["state"] == "Stopped"


def test_cell_and_model_must_agree(tmp_path: Path) -> None:
    cell = ScriptedCell(PAPER.with_positions(1))
    with Journal(tmp_path / "j") as journal, pytest.raises(CellError, match=r"\bpositions\b.*\b1\b.*\b2\b"):
        sort_objects(cell, scripted([]), AlwaysLook(), PAPER, journal, objects=1)


def test_a_class_for_empty_cups_without_a_bin_must_be_the_last(tmp_path: Path) -> None:
    names = ["none", "nut", "bolt"]
    model = beltsort.SortingModel(names, ["v", "w"], with_empty().p_obs, empty="none")
    with (
        Journal(tmp_path / "j") as journal,
        pytest.raises(CellError, match=r"\bclasses\b.*\['nut', 'bolt'\]"),
    ):
        sort_objects(ScriptedCell(model), scripted([]), AlwaysLook(), model, journal, objects=1)


def test_a_plan_is_journalled_with_its_reasons(tmp_path: Path) -> None:
    planner = beltsort.Despot(PAPER, trials=2, scenarios=50)
    _, entries = run(tmp_path, ScriptedCell(PAPER), itertools.repeat([1, 1]), planner, objects=1)
    plans = [entry.data for entry in entries if entry.kind == "plan"]
    assert set(plans[0]["action"]) == {"move"}
    assert set(plans[0]) == {"action", "values", "lower", "upper", "trials", "seconds", "late"}
    assert len(plans[0]["values"]) == 7
    best = max(plans[0]["values"], key=lambda action: action["value"])
    assert plans[0]["action"] == {"move": best["move"]}


def test_a_scan_follows_each_decision_while_objects_remain(tmp_path: Path) -> None:
    model = changed(observe_after_decision=True)
    cell = ScriptedCell(model)
    scans: list[Sequence[Glimpse] | str] = [[1, 0], [2, 2], [0, 1], [3, 3]]
    report, entries = run(tmp_path, cell, scans, LookOnceEach(), objects=2)
    assert report.steps == 4
    assert [d.looks for d in report.decisions] == [1, 3]
    belief = Belief(model)
    belief.observe(1, [1, 0])
    belief.advance()
    belief.observe(1, [2, 2])
    journalled = [entry.data for entry in entries if entry.kind == "scan"]
    assert len(journalled) == 3
    assert journalled[1]["belief"] == belief.probabilities.tolist()
    assert cell.stamps[1] == 1 + cell.acts.index(("advance", 1)), "no picture older than the belt's stop"


def test_a_journalled_belief_can_be_rebuilt(tmp_path: Path) -> None:
    model = changed(repeat=0.5)
    _, entries = run(tmp_path, ScriptedCell(model), [[1, 0], [1, None]], LookOnceEach(), objects=2)
    expected = Belief(model)
    expected.observe(1, [1, 0])
    scan = next(entry.data for entry in entries if entry.kind == "scan")
    assert Belief(model, scan["belief"], scan["last_labels"]) == expected


@pytest.mark.parametrize("belt_ends", [True, False])
def test_the_policy_knows_where_the_belt_ends(tmp_path: Path, belt_ends: bool) -> None:
    policy = Recorded(LookOnceEach())
    run(tmp_path, ScriptedCell(PAPER), itertools.repeat([1, 1]), policy, objects=3, belt_ends=belt_ends)
    remaining = [belief.remaining for belief, _ in policy.asked]
    assert remaining == ([3, 3, 2, 2, 1, 1] if belt_ends else [None] * 6)


def test_an_empty_cup_is_decided_and_passed_over(tmp_path: Path) -> None:
    model = with_empty()
    cell = ScriptedCell(model)
    scans: list[Sequence[Glimpse] | str] = [[EMPTY, 1], [1, EMPTY], [EMPTY, EMPTY]]
    report, entries = run(tmp_path, cell, scans, LookOnceEach(), objects=3)
    assert report.skipped == (0, 2)
    assert [(d.object, d.label) for d in report.decisions] == [(1, 1)]
    assert report.steps == 6
    assert [act for act in cell.acts if act[0] == "sort"] == [("sort", 1)]
    belief = Belief(model)
    belief.observe(1, [2, 1])
    scan, skip = (next(e.data for e in entries if e.kind == kind) for kind in ("scan", "skip"))
    assert (scan["labels"], scan["empty"]) == ([2, 1], [True, False])
    assert scan["belief"] == belief.probabilities.tolist()
    assert skip == {"viewpoints": [1], "decided": True}


@pytest.mark.parametrize("reject_bin", [None, 7])
def test_a_doubtful_empty_cup_is_rejected_where_there_is_a_bin(
    tmp_path: Path, reject_bin: int | None
) -> None:
    cell = ScriptedCell(with_empty(), reject_bin=reject_bin)
    report, _ = run(tmp_path, cell, itertools.repeat([EMPTY, None]), AlwaysLook(), 1, Rules(max_looks=3))
    assert report.skipped == (() if reject_bin else (0,))
    assert [act[1] for act in cell.acts if act[0] == "sort"] == ([7] if reject_bin else [])
