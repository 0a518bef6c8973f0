"""Metrics of a run for Prometheus, with the extra `metrics`; docs/monitoring.md lists them."""

import logging
import time
from math import inf
from pathlib import Path
from types import TracebackType
from typing import Self

from beltsort._core import __version__
from beltsort.cell.commands import SortInto
from beltsort.cell.wrappers.recorder import Recorded
from beltsort.errors import CellError
from beltsort.sorting.command import Command
from beltsort.sorting.entries import (
    CommandDone,
    CommandFailed,
    Decided,
    Drifted,
    Intended,
    ObjectsPassed,
    Planned,
    Resumed,
    ScanElsewhere,
    Scanned,
    ScanUnusable,
    Skipped,
    Started,
    State,
    StateChanged,
)
from beltsort.sorting.journal import Entry
from beltsort.sorting.journal_files import journal_bytes
from beltsort.sorting.moving.entries import Diverting, Fate, Looked, MovingStarted, ObjectLeft
from beltsort.sorting.moving.state import MovingState
from beltsort.sorting.progress import Progress
from beltsort.util.extras import extra

with extra("metrics"):
    from prometheus_client import (
        CollectorRegistry,
        Counter,
        Enum,
        Gauge,
        Histogram,
        Info,
        ProcessCollector,
        start_http_server,
    )

log = logging.getLogger(__name__)

ADDRESS = "127.0.0.1"
OUTCOMES = {Fate.IN_BIN: "sorted", Fate.EMPTY: "empty"}
"""The outcome of an object that has left a belt that never stops; the others have passed."""
STARTING = "Starting"
"""The state before the first entry."""
BELIEFS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 1.0)
LOOKS = (1, 2, 3, 4, 6, 8, 12, 20, 40, 60)
PLAN_SECONDS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0)
CALL_SECONDS = (0.001, 0.005, 0.02, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0)
"""Upper bounds of the histograms' buckets."""


class RunMetrics:
    """Metrics of one run: a listener of its journal and of the calls of its devices.

    Counters count from the start of the process, also of a run that is resumed, as Prometheus expects it.

    Attributes
    ----------
    registry
        The metrics, apart from any others of the process.
    folder
        Folder of the run, of whose journal the size is told; None if not known.
    """

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self.folder: Path | None = None
        self._pending: Command | None = None
        self._left: int | None = None  # number of the last object that was sorted or skipped
        self._end = 0.0  # number that follows the last object's
        self._failed = False
        self._of_objects()
        self._of_looks_and_plans()
        self._of_run()
        self._of_devices()

    def _of_objects(self) -> None:
        own = self.registry
        self.objects = Counter(
            "beltsort_objects",
            "Objects that have left the belt end: sorted, empty (cups), passed (unsorted).",
            ["outcome"],
            registry=own,
        )
        for outcome in ("sorted", "empty", "passed"):
            self.objects.labels(outcome)
        self.decisions = Counter("beltsort_decisions", "Decisions, by bin.", ["bin"], registry=own)
        self.forced = Counter(
            "beltsort_forced_decisions", "Decisions that a rule has forced.", ["rule"], registry=own
        )
        for rule in ("max_looks", "impossible_labels"):
            self.forced.labels(rule)
        self.belief = Histogram(
            "beltsort_decision_belief",
            "Probability at the decision that its bin is right.",
            buckets=BELIEFS,
            registry=own,
        )
        self.decision_looks = Histogram(
            "beltsort_decision_looks", "Looks at an object until its decision.", buckets=LOOKS, registry=own
        )

    def _of_looks_and_plans(self) -> None:
        own = self.registry
        self.looks = Counter("beltsort_looks", "Scans that were used.", registry=own)
        self.scan_failures = Counter(
            "beltsort_scan_failures",
            "Scans that were not used: unusable, or from another viewpoint.",
            ["reason"],
            registry=own,
        )
        for reason in ("unusable", "wrong_viewpoint"):
            self.scan_failures.labels(reason)
        self.drift = Counter("beltsort_drift_alarms", "Alarms of drift detection.", registry=own)
        self.plans = Histogram(
            "beltsort_plan_seconds", "Time of a plan, seconds.", buckets=PLAN_SECONDS, registry=own
        )
        self.late = Counter("beltsort_late_plans", "Plans that took longer than their budget.", registry=own)

    def _of_run(self) -> None:
        own = self.registry
        self.run = Info("beltsort_run", "The run and the version of beltsort.", registry=own)
        self.state = Enum("beltsort_run_state", "State of the run.", states=[STARTING, *State], registry=own)
        self.held = Gauge("beltsort_run_held", "1 while the run is held, otherwise 0.", registry=own)
        self.holds = Counter("beltsort_holds", "How often the run was held.", registry=own)
        self.object = Gauge("beltsort_belt_end_object", "Number of the object at the belt end.", registry=own)
        self.objects_left = Gauge(
            "beltsort_objects_left",
            "Objects that are still to be sorted; +Inf if their number is not limited.",
            registry=own,
        )
        self.last_entry = Gauge(
            "beltsort_last_entry_timestamp_seconds", "Time of the last journal entry.", registry=own
        )
        size = Gauge("beltsort_journal_bytes", "Size of the journal's files.", registry=own)
        size.set_function(lambda: 0 if self.folder is None else journal_bytes(self.folder))
        ProcessCollector(registry=own)

    def _of_devices(self) -> None:
        own = self.registry
        self.command_failures = Counter(
            "beltsort_command_failures", "Attempts at commands that failed.", ["act"], registry=own
        )
        for act in ("move", "advance", "sort"):
            self.command_failures.labels(act)
        call = ["device", "call"]
        self.calls = Histogram(
            "beltsort_device_call_seconds",
            "Time of a call of a device, seconds; failed ones are included.",
            call,
            buckets=CALL_SECONDS,
            registry=own,
        )
        self.call_failures = Counter(
            "beltsort_device_call_failures", "Calls of devices that failed.", call, registry=own
        )

    def resume(self, progress: Progress | MovingState) -> None:
        """Continue with a run that is resumed, whose entries do not say where it was."""
        if isinstance(progress, MovingState):
            self._end = inf if progress.objects is None else progress.objects
            self._identify(progress.run)
            return
        self._end = inf if progress.objects is None else progress.end
        self._pending = progress.pending
        self._identify(progress.run)

    def called(self, recorded: Recorded) -> None:
        """Count a call of a device; a failure is logged once, and no call is counted after it."""
        if self._failed:
            return
        try:
            labels = (recorded.device, recorded.call.name)
            self.calls.labels(*labels).observe(recorded.seconds)
            if recorded.error is not None:
                self.call_failures.labels(*labels).inc()
        except Exception:  # any exception: the run must go on
            self._failed = True
            log.exception("calls of devices are no longer counted")

    def __call__(self, entry: Entry) -> None:
        """Count an entry of the journal."""
        self.last_entry.set(time.time())
        if entry.object is not None:
            self.object.set(entry.object)
            self.objects_left.set(max(0, self._end - entry.object))
        match entry.content:
            case Started(run=run, first=first, objects=objects):
                self._end = inf if objects is None else first + objects
                self.objects_left.set(self._end - first)
                self._identify(run)
            case MovingStarted(run=run, objects=objects):
                self._end = inf if objects is None else objects
                self.objects_left.set(self._end)
                self._identify(run)
            case Resumed():
                pass
            case StateChanged(state):
                self._enter(state)
            case Intended(command):
                self._pending = command
            case CommandDone():
                self._done(entry)
            case CommandFailed():
                act = "unknown" if self._pending is None else self._pending.act.verb
                self.command_failures.labels(act).inc()
            case _:
                self._observed(entry)

    def _observed(self, entry: Entry) -> None:
        match entry.content:
            case Planned(seconds=seconds, late=late):
                self.plans.observe(seconds)
                self.late.inc(int(late))
            case Scanned() | Looked():
                self.looks.inc()
            case Diverting(name=name, belief=belief, looks=looks):
                self.decisions.labels(name).inc()
                self.belief.observe(belief)
                self.decision_looks.observe(looks)
            case ObjectLeft(fate=fate):
                self.objects.labels(OUTCOMES.get(fate, "passed")).inc()
            case ScanUnusable():
                self.scan_failures.labels("unusable").inc()
            case ScanElsewhere():
                self.scan_failures.labels("wrong_viewpoint").inc()
            case Drifted():
                self.drift.inc()
            case Decided() as decided:
                self._decided(decided)
            case Skipped():
                self.objects.labels("empty").inc()
                self._left = entry.object
            case ObjectsPassed(index) if entry.object is not None:
                first = entry.object + int(self._left == entry.object)
                self.objects.labels("passed").inc(max(0, min(index, self._end) - first))

    def _decided(self, decided: Decided) -> None:
        self.decisions.labels(decided.name or str(decided.bin)).inc()
        self.belief.observe(decided.belief)
        self.decision_looks.observe(decided.looks)
        if decided.forced is not None:
            self.forced.labels(decided.forced).inc()

    def _done(self, entry: Entry) -> None:
        command, self._pending = self._pending, None
        if command is not None and isinstance(command.act, SortInto):
            self.objects.labels("sorted").inc()
            self._left = entry.object

    def _enter(self, state: State) -> None:
        self.state.state(state)
        self.held.set(int(state is State.HELD))
        self.holds.inc(int(state is State.HELD))

    def _identify(self, run: str) -> None:
        self.run.info({"run": run, "version": __version__})


class MetricsServer:
    """Serves metrics over HTTP on this computer as long as it is open, from a thread of its own.

    Parameters
    ----------
    metrics
        The metrics.
    port
        Port to listen on; 0: any that is free.

    Raises
    ------
    CellError
        If the port is taken.

    Attributes
    ----------
    url
        Address of the metrics.
    """

    def __init__(self, metrics: RunMetrics, port: int) -> None:
        try:
            self._server, self._thread = start_http_server(port, ADDRESS, metrics.registry)
        except OSError as reason:
            raise CellError(
                f"metrics cannot be served on port {port}: {reason}; choose another, or 0 for a free one"
            ) from reason
        self.url = f"http://{ADDRESS}:{self._server.server_port}/metrics"

    def __enter__(self) -> Self:
        """Use the server as a context that stops it."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
