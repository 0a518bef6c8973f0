"""Metrics of a run as Prometheus reads them."""

import re
import socket
from dataclasses import replace
from pathlib import Path
from urllib.request import urlopen

import pytest
from prometheus_client import REGISTRY
from prometheus_client.parser import text_string_to_metric_families

from beltsort.cell.wrappers.recorder import Call, Recorded
from beltsort.errors import CellError
from beltsort.monitoring.metrics import STARTING, MetricsServer, RunMetrics
from beltsort.sorting.entries import AnyContent, Drifted, ObjectsPassed, Planned, ScanElsewhere, State
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal import Entry
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.record import progress_in
from tests.monitoring.runs import resumed, run_of

PAGE = Path(__file__).parents[2] / "docs" / "monitoring.md"


def read(url: str) -> dict[str, float]:
    """Return every sample over HTTP, by its name and labels."""
    with urlopen(url) as answer:
        text = answer.read().decode()
    families = text_string_to_metric_families(text)
    return {
        f"{sample.name}{''.join(f' {value}' for value in sample.labels.values())}": sample.value
        for family in families
        for sample in family.samples
    }


def test_a_run_is_counted(tmp_path: Path) -> None:
    metrics = RunMetrics()
    with MetricsServer(metrics, 0) as server:
        start = read(server.url)
        assert start[f"beltsort_run_state {STARTING}"] == 1
        assert start["beltsort_objects_total sorted"] == start["beltsort_journal_bytes"] == 0
        metrics.folder = tmp_path
        report = run_of(tmp_path, metrics)
        found = read(server.url)
    assert found["beltsort_objects_total sorted"] == len(report.decisions) == 3
    assert found["beltsort_objects_total empty"] == len(report.skipped) == 1
    assert found["beltsort_objects_total passed"] == 0
    decided = {name: n for name, n in found.items() if name.startswith("beltsort_decisions_total")}
    assert sum(decided.values()) == 3
    assert decided["beltsort_decisions_total livarno"] >= 1
    assert found["beltsort_decision_belief_count"] == found["beltsort_decision_looks_count"] == 3
    assert found["beltsort_decision_belief_sum"] == pytest.approx(sum(d.belief for d in report.decisions))
    assert found["beltsort_decision_looks_sum"] == sum(decision.looks for decision in report.decisions)
    assert found["beltsort_forced_decisions_total max_looks"] == 0
    assert found["beltsort_scan_failures_total unusable"] == 1
    assert found["beltsort_command_failures_total sort"] == 1
    assert found[f"beltsort_run_state {State.COMPLETE}"] == 1
    assert found["beltsort_run_held"] == found["beltsort_holds_total"] == found["beltsort_objects_left"] == 0
    assert found["beltsort_journal_bytes"] >= (tmp_path / JOURNAL).stat().st_size > 0
    assert found["process_resident_memory_bytes"] > 1e6
    assert not any(metric.name.startswith("beltsort") for metric in REGISTRY.collect())


def test_a_held_run_is_seen_and_goes_on(tmp_path: Path) -> None:
    metrics = RunMetrics()
    with pytest.raises(HeldError):
        run_of(tmp_path, metrics, refused=9)
    progress = progress_in(tmp_path / JOURNAL)
    with MetricsServer(metrics, 0) as server:
        held = read(server.url)
        assert (held["beltsort_run_held"], held[f"beltsort_run_state {State.HELD}"]) == (1, 1)
        assert held["beltsort_holds_total"] >= 1
        assert held["beltsort_objects_left"] == 2
    metrics = RunMetrics()
    metrics.resume(progress)
    resumed(tmp_path, metrics, first=progress.index)
    with MetricsServer(metrics, 0) as server:
        found = read(server.url)
    assert found["beltsort_objects_total sorted"] == 2
    assert found["beltsort_run_held"] == found["beltsort_objects_left"] == 0
    assert any(name == f"beltsort_run_info {progress.run}" for name in (n.rsplit(" ", 1)[0] for n in found))


def heard(metrics: RunMetrics, *contents: AnyContent) -> None:
    for number, content in enumerate(contents, 1):
        metrics(Entry(number, "", 2, content))


def test_plans_drift_and_scans_from_elsewhere_are_counted() -> None:
    metrics = RunMetrics()
    plan = {"action": {"move": 1}, "values": [], "lower": 0.0, "upper": 1.0, "trials": 3}
    quick = Planned(**plan, seconds=0.02)  # type: ignore[arg-type]  # fields by name
    heard(metrics, quick, replace(quick, seconds=0.7, late=True))
    heard(metrics, Drifted(0, 1, 20, 100.0), ScanElsewhere(1, 2, 30.0, 200.0))
    metrics._end = 10
    heard(metrics, ObjectsPassed(5))
    with MetricsServer(metrics, 0) as server:
        found = read(server.url)
    assert (found["beltsort_plan_seconds_count"], found["beltsort_late_plans_total"]) == (2, 1)
    assert found["beltsort_plan_seconds_bucket 0.025"] == 1
    assert found["beltsort_drift_alarms_total"] == found["beltsort_scan_failures_total wrong_viewpoint"] == 1
    assert found["beltsort_objects_total passed"] == 3


def test_calls_of_devices_are_timed() -> None:
    metrics = RunMetrics()
    metrics.called(Recorded("belt", Call("advance_to", 3, "a-1"), 0.0, 1.5, None))
    metrics.called(Recorded("belt", Call("advance_to", 3, "a-1"), 0.0, 0.5, "CommandError('x')"))
    with MetricsServer(metrics, 0) as server:
        found = read(server.url)
    assert found["beltsort_device_call_seconds_count advance_to belt"] == 2
    assert found["beltsort_device_call_seconds_sum advance_to belt"] == 2.0
    assert found["beltsort_device_call_failures_total advance_to belt"] == 1


def test_metrics_that_fail_end_no_run(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    metrics = RunMetrics()
    metrics.calls = metrics.looks = None  # type: ignore[assignment]  # as if the library failed
    for _ in range(2):
        metrics.called(Recorded("arm", Call("health"), 0.0, 0.1, None))
    assert len(caplog.records) == 1
    assert len(run_of(tmp_path, metrics).decisions) == 3


def test_a_port_that_is_taken_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(CellError, match=rf"\b{port}\b.*\bchoose another\b"):
            MetricsServer(RunMetrics(), port)


def test_the_documentation_has_every_metric() -> None:
    named = set(re.findall(r"^\| `(beltsort_\w+)", PAGE.read_text("utf-8"), re.MULTILINE))
    found = set()
    for metric in RunMetrics().registry.collect():
        if metric.name.startswith("beltsort_"):
            suffix = {"counter": "_total", "info": "_info"}.get(metric.type, "")
            found.add(f"{metric.name}{suffix}")
    assert named == found
