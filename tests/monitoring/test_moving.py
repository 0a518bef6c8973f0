"""A run on a belt that never stops in the log, in the metrics and as text."""

import logging

import pytest

from beltsort.monitoring.entry_logger import LOGGER, EntryLogger
from beltsort.monitoring.metrics import RunMetrics
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import Diverting, Fate, Looked, ObjectLeft
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.moving.state import MovingState
from tests.sorting.moving.runs import entries, plant, sort


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> list[Entry]:
    """Return the entries of a run on a belt with an empty cup."""
    folder = tmp_path_factory.mktemp("run")
    sort(folder, plant())
    return entries(folder)


def value(metrics: RunMetrics, name: str, **labels: str) -> float:
    found = metrics.registry.get_sample_value(name, labels)
    assert found is not None
    return found


def test_a_run_is_counted(run: list[Entry]) -> None:
    metrics = RunMetrics()
    for entry in run:
        metrics(entry)
    report = MovingReport.of(MovingState.after(run))
    passed = report.objects - report.fates[Fate.IN_BIN] - report.fates[Fate.EMPTY]
    assert value(metrics, "beltsort_objects_total", outcome="sorted") == report.fates[Fate.IN_BIN] > 0
    assert value(metrics, "beltsort_objects_total", outcome="empty") == report.fates[Fate.EMPTY]
    assert value(metrics, "beltsort_objects_total", outcome="passed") == passed
    assert value(metrics, "beltsort_looks_total") == report.scans
    decided = [entry.content for entry in run if isinstance(entry.content, Diverting)]
    assert value(metrics, "beltsort_decision_belief_sum") == pytest.approx(sum(d.belief for d in decided))
    assert value(metrics, "beltsort_objects_left") == 0


def test_counters_of_a_run_that_is_resumed_begin_at_0_and_what_is_left_is_known(run: list[Entry]) -> None:
    half = run[: len(run) // 2]
    metrics, state = RunMetrics(), MovingState.after(half)
    metrics.resume(state)
    for entry in run[len(half) :]:
        metrics(entry)
    later = sum(isinstance(entry.content, Looked) for entry in run[len(half) :])
    assert value(metrics, "beltsort_looks_total") == later > 0
    assert value(metrics, "beltsort_objects_left") == 0


def test_the_log_has_every_entry_and_no_steps(run: list[Entry], caplog: pytest.LogCaptureFixture) -> None:
    logger = EntryLogger()
    with caplog.at_level(logging.DEBUG, logger=LOGGER):
        for entry in run:
            logger(entry)
    assert len(caplog.records) == len(run)
    assert logger.step is None
    state = MovingState.after(run)
    assert (logger.run, logger.object) == (state.run, 12)
    missed = [r.levelno for r in caplog.records if "MISSED" in r.getMessage()]
    assert missed == [logging.WARNING] * state.fates.get(Fate.MISSED, 0)
    resumed = EntryLogger()
    resumed.resume(state)
    assert (resumed.run, resumed.object) == (state.run, state.settled)


def test_every_object_that_has_left_has_a_line(run: list[Entry]) -> None:
    formatter = EntryFormatter()
    lines = [(entry.content, formatter.format(entry)) for entry in run]
    bins = {content.number: content.name for content, _ in lines if isinstance(content, Diverting)}
    left = [(content, line) for content, line in lines if isinstance(content, ObjectLeft)]
    assert len(left) == 12
    for content, line in left:
        assert line is not None
        assert line.startswith(f"object {content.number:>2}  ")
        if content.fate is Fate.IN_BIN:
            assert line.endswith(f"in bin {bins[content.number]}")
    looks = [line for content, line in lines if isinstance(content, Looked) and content.seen]
    assert looks[0] is not None
    assert looks[0].startswith("look from p1: object 0 ")
    assert (lines[0][1] or "").startswith("sorting 12 objects on a belt that never stops: elongated")


def test_actions_of_policies_have_names(run: list[Entry]) -> None:
    formatter = EntryFormatter()
    formatter.format(run[0])
    assert formatter.name({"move": 1}) == "look from p2"
    assert formatter.name({"wait": 1}) == "wait"
    assert formatter.name({"decide": 2, "position": 1}) == "decide mushroom at position 2"
