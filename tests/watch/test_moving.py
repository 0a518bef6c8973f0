"""The page of a run on a belt that never stops, as a function of the journal."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort import Move, MovingBelief
from beltsort.errors import JournalError
from beltsort.planning.bins import sorting_statistics
from beltsort.planning.decisions import right_bins
from beltsort.sorting.entries import AnyContent, Chosen, Planned, ScanUnusable
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.moving.entries import (
    Anchored,
    DiversionTold,
    Diverting,
    EncoderJumped,
    Fate,
    FoundEmpty,
    Looked,
    MovingStarted,
    ObjectLeft,
    SeenObject,
)
from beltsort.sorting.moving.loop import sort_moving
from beltsort.sorting.moving.state import MovingState
from beltsort.watch.moving import MovingHistory, moving_state_of
from tests.sorting.moving.cells import Perception
from tests.sorting.moving.runs import BELT, RULES, entries, planner, plant, sort
from tests.watch.moving import check_shown, history_of

TABLE = [[[[0.8, 0.2], [0.7, 0.3], [0.2, 0.8]]]]
SCREWS = beltsort.SortingModel(
    ["nut", "bolt"],
    ["front"],
    TABLE * 2,
    modes=[[0.5, 0.5], [1.0]],
    labels=["round", "long"],
    bins=["good", "by hand"],
    reward=[[10.0, -50.0], [-5.0, 10.0]],
)
"""A class with two modes, and bins that are not the classes."""


class LookOn:
    """A policy that decides nothing."""

    def act(self, belief: MovingBelief, viewpoint: int) -> Move:
        return Move(0)


def of(*contents: AnyContent, model: beltsort.SortingModel = SCREWS) -> MovingHistory:
    """Return the history of entries that are ten seconds apart."""
    belt = beltsort.MovingBelt(model, ticks_per_place=6, reach=2, seconds_per_tick=0.5)
    start = MovingStarted(run="a", objects=None, belt=belt.to_json())
    return history_of(
        [
            Entry(n, f"2026-01-01T00:{n // 6:02}:{n % 6}0+00:00", 0, content)
            for n, content in enumerate([start, *contents], start=1)
        ]
    )


ANCHOR = Anchored("boot", 0.2, 0.0, 0)


def divert(number: int, bin: int, true: int | None = None) -> Diverting:
    name = SCREWS.bins[bin]
    return Diverting(f"a-{number}", number, 0.2 * number, bin, name, "boot", 0.9, 3, true)


def steps_in(run: list[Entry]) -> Iterator[tuple[int, int, Planned | Chosen]]:
    """Yield number, index and content of the entry of each planner step."""
    plans = [(index, entry.content) for index, entry in enumerate(run)]
    chosen = [(index, each) for index, each in plans if isinstance(each, Planned | Chosen)]
    for number, (index, content) in enumerate(chosen, start=1):
        yield number, index, content


def test_every_step_is_shown_as_it_was_chosen(moving: Path) -> None:
    run = entries(moving)
    history = history_of(run)
    last = 0
    for number, index, content in steps_in(run):
        shown, state = moving_state_of(history, number), MovingState.after(run[:index])
        check_shown(shown, state)
        assert shown.moment.object >= last, "the belt does not go back"
        last = shown.moment.object
        plan = shown.moment.plan
        assert plan is not None
        assert (plan.step, shown.moment.step) == (number, number)
        assert [action.value for action in plan.values if action.chosen] == [
            max(action.value for action in plan.values)
        ]
        decision = run[index + 1].content
        if isinstance(decision, Diverting):
            position = shown.moment.positions[content.action["position"]]
            assert position.object == decision.number
            assert plan.action == f"decide {decision.name} at position {content.action['position'] + 1}"
    assert last > 6
    assert (moving_state_of(history).first_step, moving_state_of(history).last_step) == (1, number)


def test_the_end_is_that_of_the_report(moving: Path, tmp_path: Path) -> None:
    report = sort(tmp_path, plant())
    shown = moving_state_of(history_of(entries(tmp_path)))
    assert (shown.state, shown.ended, shown.moving, shown.objects) == ("Complete", "done", True, 12)
    check_shown(shown, MovingState.after(entries(tmp_path)))
    tally = shown.moment.tally
    assert tally.fates == {str(fate): n for fate, n in report.fates.items()}
    counts = np.array(report.confusion, dtype=np.uint64)
    assert tally.right == int(counts[right_bins(BELT.model)].sum())
    for found, statistics in zip(tally.bins, sorting_statistics(BELT.model, counts).bins, strict=True):
        assert found.purity == pytest.approx(statistics.purity.value)
    decided = [entry.content for entry in entries(tmp_path) if isinstance(entry.content, Diverting)]
    assert tally.looks_per_object == pytest.approx(np.mean([each.looks for each in decided]))
    left = report.fates[Fate.IN_BIN] + report.fates[Fate.EMPTY]
    assert tally.objects_per_minute == pytest.approx(60.0 * left / tally.seconds)


def test_the_last_label_of_each_object_is_shown(moving: Path) -> None:
    run = entries(moving)
    history, empty = history_of(run), 0
    for number, index, _ in steps_in(run):
        looks = [entry.content for entry in run[:index] if isinstance(entry.content, Looked)]
        for position in moving_state_of(history, number).moment.positions:
            seen = [each for look in looks for each in look.seen if each.number == position.object]
            last = seen[-1] if seen else None
            label = "" if last is None else last.finding
            if last is not None and last.label is not None:
                label = BELT.model.labels[last.label]
            assert position.seen == label
            empty += label == "empty"
    assert empty > 0


def test_reading_on_is_reading_at_once(moving: Path) -> None:
    run = entries(moving)
    bit_by_bit = MovingHistory(run[0])
    for entry in run:
        bit_by_bit.read([entry])
        moving_state_of(bit_by_bit)
    assert moving_state_of(bit_by_bit) == moving_state_of(history_of(run))


def test_a_journal_of_which_the_beginning_is_gone_is_shown_from_its_snapshot_on(tmp_path: Path) -> None:
    cell = plant()
    with Journal(tmp_path / "journal.sqlite", largest=60_000) as journal:
        sort_moving(cell, Perception(cell), planner(), BELT, journal, objects=12, rules=RULES)
    run = entries(tmp_path)
    first = max(n for n, entry in enumerate(run) if entry.kind == "moving_snapshot")
    assert first > 0
    rest = history_of(run[first:])
    check_shown(moving_state_of(rest), MovingState.after(run))
    whole = moving_state_of(history_of(run)).moment
    for number, index, _ in steps_in(run[first:]):
        check_shown(moving_state_of(rest, number), MovingState.after(run[: first + index]))
    now = moving_state_of(rest).moment
    assert (now.positions, now.tally.bins) == (whole.positions, whole.tally.bins)
    done = sum(content.fate in ("in bin", "empty") for content in lefts(run[first:]))
    per_minute = now.tally.objects_per_minute
    assert per_minute == (pytest.approx(60.0 * done / now.tally.seconds) if done else None)


def lefts(run: list[Entry]) -> list[ObjectLeft]:
    return [entry.content for entry in run if isinstance(entry.content, ObjectLeft)]


def test_modes_and_bins_that_are_not_the_classes() -> None:
    kinds = [0.25, 0.25, 0.5]
    look = Looked(0, 1.0, 0.0, [SeenObject(0, 0.0, 1, "object", kinds), SeenObject(1, 0.2, None, "hidden")])
    end, second = moving_state_of(of(ANCHOR, look)).moment.positions
    assert end.belief == [0.5, 0.5]
    assert (end.likely, end.bins, end.looks, end.seen) == (None, [0.5, 0.5], 1, "long")
    assert (second.looks, second.seen, second.decided) == (0, "hidden", "")


def test_what_is_decided_is_shown_until_it_leaves() -> None:
    look = Looked(0, 1.0, 0.0, [])
    history = of(ANCHOR, look, divert(0, 1, true=1), FoundEmpty(1, 0.9, 2))
    assert [each.decided for each in moving_state_of(history).moment.positions] == ["by hand", "empty cup"]
    done = DiversionTold("a-0", 0, "done")
    history = of(ANCHOR, look, divert(0, 1, true=1), done, ObjectLeft(0, Fate.IN_BIN))
    moment = moving_state_of(history).moment
    assert [each.object for each in moment.positions] == [1, 2]
    assert [(found.objects, found.right, found.purity) for found in moment.tally.bins] == [
        (0, 0, None),
        (1, 1, 1.0),
    ]
    unknown = of(ANCHOR, look, divert(0, 1), done, ObjectLeft(0, Fate.IN_BIN))
    tally = moving_state_of(unknown).moment.tally
    assert (tally.right, tally.bins[1].right, tally.bins[1].purity) == (None, None, None)


def test_objects_have_no_number_before_the_first_cup_is_seen() -> None:
    shown = moving_state_of(of())
    assert [each.object for each in shown.moment.positions] == [None, None]
    assert (shown.first_step, shown.last_step, shown.moment.plan) == (0, 0, None)


@pytest.mark.parametrize(
    ("content", "kind", "text"),
    [
        (ObjectLeft(0, Fate.MISSED, "it passed the exit undecided, unseen"), "missed", "passed the exit"),
        (ObjectLeft(0, Fate.TOO_LATE), "too late", "TOO LATE"),
        (ObjectLeft(0, Fate.LOST), "lost", "object  0"),
        (EncoderJumped("boot", "by 3 m"), "encoder", "by 3 m"),
        (ScanUnusable("no point"), "scan failure", "no point"),
        (Anchored("next", 0.2, 0.0, 9, uncounted=4), "restart", "up to 4 passed before"),
    ],
)
def test_what_goes_wrong_is_an_alarm(content: AnyContent, kind: str, text: str) -> None:
    shown = moving_state_of(of(ANCHOR, content))
    assert [(alarm.kind, text in alarm.text) for alarm in shown.alarms] == [(kind, True)]
    assert shown.alarm_counts == {kind: 1}


def test_what_goes_as_it_should_is_no_alarm() -> None:
    told = DiversionTold("a-0", 0, "done")
    history = of(ANCHOR, divert(0, 1), told, ObjectLeft(0, Fate.IN_BIN), ObjectLeft(1, Fate.EMPTY))
    assert moving_state_of(history).alarms == []


def test_a_diversion_that_was_refused_is_an_alarm() -> None:
    refused = DiversionTold("a-0", 0, "not done", "the bin is full; empty it", retry=True)
    (alarm,) = moving_state_of(of(ANCHOR, divert(0, 1), refused)).alarms
    assert (alarm.kind, "empty it" in alarm.text) == ("refused", True)


def test_objects_that_passed_uncounted_are_told() -> None:
    again = Anchored("next", 0.2, 0.0, 9, uncounted=4)
    assert moving_state_of(of(ANCHOR, again)).moment.tally.uncounted == 4


def test_another_policy_compares_no_values(tmp_path: Path) -> None:
    sort(tmp_path, plant(), LookOn())
    shown = moving_state_of(history_of(entries(tmp_path)))
    assert shown.moment.plan is not None
    assert (shown.moment.plan.action, shown.moment.plan.values) == ("look from p1", [])
    assert shown.moment.tally.fates is not None
    assert shown.alarm_counts["missed"] == shown.moment.tally.fates["missed"] > 6
    assert shown.moment.tally.passed == shown.alarm_counts["missed"]


def test_a_step_that_is_not_there_is_an_error(moving: Path) -> None:
    with pytest.raises(JournalError, match="there is no step 999; there are steps 1 to"):
        moving_state_of(history_of(entries(moving)), 999)
