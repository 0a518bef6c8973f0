"""What the page shows, as a function of the journal."""

from pathlib import Path

import numpy as np
import pytest

from beltsort.cell.commands import EmergencyStopError, Outcome
from beltsort.errors import JournalError
from beltsort.planning.decisions import right_bins
from beltsort.sorting.audit import entries_of, steps_of
from beltsort.sorting.entries import AnyContent, Ended, Requested, Started, State, StateChanged
from beltsort.sorting.journal import Entry
from beltsort.sorting.progress import Progress
from beltsort.sorting.report import confusion
from beltsort.sorting.runs import read_true_classes
from beltsort.watch.history import RunHistory, most_likely
from beltsort.watch.state import state_of
from tests.watch.runs import TRUE, model_of


def history_of(entries: list[Entry]) -> RunHistory:
    history = RunHistory(entries[0])
    history.read(entries)
    return history


def of(*contents: AnyContent, seconds: int = 10) -> RunHistory:
    """Return the history of entries that are so many seconds apart."""
    model = model_of(2)
    start = Started(run="a", objects=3, model=model.to_json())
    return history_of(
        [
            Entry(n, f"2026-01-01T00:{n * seconds // 60:02}:{n * seconds % 60:02}+00:00", 0, content)
            for n, content in enumerate([start, *contents], start=1)
        ]
    )


def test_every_step_is_shown_as_it_was_chosen(finished: Path) -> None:
    entries = entries_of(finished)
    history = history_of(entries)
    steps = list(steps_of(entries))
    assert (state_of(history).first_step, state_of(history).last_step) == (1, len(steps))
    for step in steps:
        moment = state_of(history, step.number).moment
        belief = [position.belief for position in moment.positions]
        np.testing.assert_allclose(belief, step.belief.probabilities, atol=1e-4)
        assert (moment.object, moment.viewpoint) == (step.entry.object, step.viewpoint)
        assert moment.plan is not None
        assert [action.chosen for action in moment.plan.values].count(True) == 1
        values = [action.value for action in moment.plan.values]
        assert values == sorted(values, reverse=True)


def test_the_end_is_that_of_the_journal(finished: Path) -> None:
    entries = entries_of(finished)
    progress, shown = Progress.after(entries), state_of(history_of(entries), true=read_true_classes(finished))
    assert (shown.state, shown.ended, shown.entry) == ("Complete", "done", entries[-1].number)
    assert [position.object for position in shown.moment.positions] == [None, None]
    tally = shown.moment.tally
    assert tally.sorted == len(progress.decisions) == len(TRUE)
    assert tally.looks_per_object == pytest.approx(np.mean([d.looks for d in progress.decisions]))
    assert tally.objects_per_minute == pytest.approx(60.0 * len(TRUE) / tally.seconds)
    decided = ((d.object, d.label) for d in progress.decisions)
    counts = confusion(decided, TRUE.__getitem__, progress.model)
    assert [found.objects for found in tally.bins] == counts.sum(axis=1).tolist()
    assert tally.right == int(counts[right_bins(progress.model)].sum())
    for row, found in zip(counts, tally.bins, strict=True):
        if row.sum():
            assert found.purity == pytest.approx((found.right or 0) / row.sum())


def test_counts_grow_from_step_to_step(finished: Path) -> None:
    history = history_of(entries_of(finished))
    sorted_by = [state_of(history, step).moment.tally.sorted for step in history.moments]
    assert sorted_by == sorted(sorted_by)
    assert sorted_by[0] == 0
    without = state_of(history).moment.tally
    assert without.right is None
    assert {found.purity for found in without.bins} == {None}


def test_reading_on_is_reading_at_once(finished: Path) -> None:
    entries = entries_of(finished)
    bit_by_bit = RunHistory(entries[0])
    for entry in entries:
        bit_by_bit.read([entry])
        state_of(bit_by_bit)
    assert state_of(bit_by_bit) == state_of(history_of(entries))


def test_bins_are_shown_where_they_are_not_the_classes(four: Path) -> None:
    history = history_of(entries_of(four))
    right = right_bins(history.progress.model)
    moment = state_of(history, 2).moment
    assert len(moment.positions) == 4
    for position in moment.positions:
        np.testing.assert_allclose(position.bins, right @ position.belief, atol=1e-3)
    assert [found.name for found in moment.tally.bins] == ["long", "round", "by hand"]
    assert state_of(history).moment.tally.forced == state_of(history).alarm_counts.get("forced decision", 0)


def test_labels_move_with_their_objects(finished: Path) -> None:
    history = history_of(entries_of(finished))
    before: dict[int, str] = {}
    for step in history.moments:
        moment = state_of(history, step).moment
        for position in moment.positions:
            if position.object is not None and not position.looks:
                assert position.seen == ""
        shifted = moment.positions[0]
        if before and moment.object in before and moment.scan and moment.scan.object < moment.object:
            assert shifted.seen == before[moment.object]
        before = {p.object: p.seen for p in moment.positions if p.object is not None}


def test_an_unusable_scan_is_an_alarm(finished: Path) -> None:
    (alarm,) = state_of(history_of(entries_of(finished))).alarms
    assert alarm.kind == "scan failure"
    assert "0 finite points" in alarm.text


@pytest.mark.parametrize(
    ("reason", "kind", "text"),
    [
        (repr(EmergencyStopError("the button is pressed", Outcome.UNKNOWN)), "emergency stop", "pressed"),
        ("ValueError('a bug')", "aborted", "a bug"),
    ],
)
def test_an_aborted_run_says_why(reason: str, kind: str, text: str) -> None:
    shown = state_of(of(StateChanged(State.ABORTED, reason), Ended(reason)))
    assert shown.state == "Aborted"
    assert text in shown.reason
    assert [(alarm.kind, text in alarm.text) for alarm in shown.alarms] == [(kind, True)]


def test_time_while_held_does_not_count() -> None:
    hold = Requested("hold", "ana", "2026-01-01T00:00:20+00:00")
    go_on = Requested("continue", "ana", "2026-01-01T00:00:40+00:00")
    held, executing = StateChanged(State.HELD, "ana asked"), StateChanged(State.EXECUTE, "ana asked")
    shown = state_of(of(hold, held, go_on, executing, Ended("done")))
    assert shown.moment.tally.seconds == 30.0  # of 50, less the 20 from `held` to `executing`
    assert [alarm.kind for alarm in shown.alarms] == ["operator", "held"]


def test_a_step_that_is_not_there_is_an_error(finished: Path) -> None:
    with pytest.raises(JournalError, match="there is no step 999; there are steps 1 to"):
        state_of(history_of(entries_of(finished)), 999)
    with pytest.raises(JournalError, match="there are no steps"):
        state_of(of(), 1)


def test_no_class_is_likely_among_equals() -> None:
    assert most_likely([0.25, 0.25, 0.25, 0.25]) is None
    assert most_likely([0.2, 0.5, 0.3]) == 1
