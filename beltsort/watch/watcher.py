"""Follows one run: its journal, the scans that it keeps, and requests to hold it."""

import threading
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from beltsort.errors import JournalError
from beltsort.planning.explanation import explain
from beltsort.sorting.holds import Answer, Reply
from beltsort.sorting.journal import entries_after, read_journal
from beltsort.sorting.kept_scans import SCANS, KeptScan, kept_scans, scan_file
from beltsort.sorting.moving.entries import MovingSnapshot, MovingStarted
from beltsort.sorting.requests import Action, Request, is_token, read_request, takes_requests, write_request
from beltsort.sorting.runs import journal_of, read_true_classes
from beltsort.sorting.settling import settle
from beltsort.watch.history import RunHistory
from beltsort.watch.moving import MovingHistory, moving_state_of
from beltsort.watch.state import RunView, state_of


@dataclass(frozen=True)
class Watched:
    """A run and the moment shown, and whether the run takes requests.

    Attributes
    ----------
    run
        The run.
    takes_requests
        Whether it was started with `--allow-hold` and still runs.
    request
        The request that stands.
    kept_scan
        Number of the journal entry of the last scan at the moment shown, if the run keeps it; else None.
    kept_scans
        Number of scans that the run keeps.
    """

    run: RunView
    takes_requests: bool
    request: Request | None
    kept_scan: int | None
    kept_scans: int


@dataclass(frozen=True)
class SceneView:
    """The last scan at the moment shown; lengths in millimetres, belt frame.

    Attributes
    ----------
    entry
        Number of its journal entry; None if the run does not keep it. Then there are no points, and camera,
        viewpoints and layout are those of another scan.
    missing
        Why it is not kept; empty if it is.
    points
        x, y, z of one point after the other.
    positions
        The belt position of each point's candidate; -1 for none.
    camera
        Position and viewing direction of the camera: x, y, z of each.
    viewpoints
        Position of each viewpoint; None where it is not known.
    layout
        Number of belt positions, their spacing, height and radius of a cup's rim.
    """

    entry: int | None
    missing: str
    points: list[int]
    positions: list[int]
    camera: list[list[float]]
    viewpoints: list[list[float] | None]
    layout: list[float]


class Watcher:
    """Reads one run as it goes on. May be used from several threads.

    Parameters
    ----------
    run
        As in `beltsort.sorting.runs.journal_of`.

    Raises
    ------
    JournalError
        If there is no journal, or it is damaged.
    """

    def __init__(self, run: Path) -> None:
        self.journal = journal_of(run)
        self.folder = self.journal.parent
        self._lock = threading.Lock()
        entries = read_journal(self.journal)
        first = entries[0]
        moving = isinstance(first.content, MovingStarted | MovingSnapshot)
        self._history: RunHistory | MovingHistory = MovingHistory(first) if moving else RunHistory(first)
        self._history.read(entries)
        self._true = read_true_classes(self.folder)
        self._explained = lru_cache(maxsize=256)(self._explain)

    def state(self, step: int | None = None) -> Watched:
        """Read what is new, and return the run; before a planner step, or as it is now.

        Raises
        ------
        JournalError
            If the journal cannot be read, or there is no such step.
        """
        with self._lock:
            self._history.read(entries_after(self.journal, self._history.last_entry))
            match self._history:
                case MovingHistory() as history:
                    run = moving_state_of(history, step)
                case history:
                    run = state_of(history, step, self._true)
        scan, kept = run.moment.scan, kept_scans(self.folder)
        return Watched(
            run,
            takes_requests(self.folder),
            read_request(self.folder),
            scan.entry if scan is not None and scan.entry in kept else None,
            len(kept),
        )

    def explanation(self, step: int) -> str:
        """Return why the action of a step was chosen, in words: the step is planned again.

        Raises
        ------
        JournalError
            If there is no such step, or the belt never stops.
        """
        return self._explained(step)

    def scene(self, step: int | None = None) -> SceneView:
        """Return the last scan before a planner step, or as it is now, if the run keeps it.

        Raises
        ------
        JournalError
            If the run keeps no scan, or there is no such step.
        """
        with self._lock:
            scan = self._history.moment(step).scan
        kept = kept_scans(self.folder)
        if not kept:
            raise JournalError(f"{self.folder / SCANS} is empty: this run has kept no scan yet")
        if scan is not None and scan.entry in kept:
            try:
                return _scene(KeptScan.load(scan_file(self.folder, scan.entry)))
            except JournalError as error:
                missing = str(error)
        else:
            missing = _why_not_kept(None if scan is None else scan.entry, kept)
        return replace(
            _scene(KeptScan.load(scan_file(self.folder, kept[-1]))),
            entry=None,
            missing=missing,
            points=[],
            positions=[],
        )

    def may_request(self, token: str) -> bool:
        """Whether a token is that of the run."""
        return is_token(self.folder, token)

    def request(self, action: Action) -> Request:
        """Ask the run to hold or to continue, and return the request.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        request = Request.now(action, "beltsort watch")
        write_request(self.folder, request)
        return request

    def settle(self, answer: Answer, question: int) -> Reply:
        """Answer the question that a journal entry asks; as `beltsort.sorting.settling.settle`."""
        return settle(self.folder, answer, "beltsort watch", question)

    def _explain(self, number: int) -> str:
        with self._lock:
            if isinstance(self._history, MovingHistory):
                raise JournalError(
                    "the belt never stops, expected one that stops: steps of this run cannot be planned "
                    "again, see the values of their actions"
                )
            moment = self._history.moments.get(number)
        if moment is None or moment.step is None:
            raise JournalError(f"there is no step {number}, or it is no longer kept")
        step = moment.step
        if step.reason is not None:
            return f"A rule chose: {step.reason}."
        plan = step.plan_again()
        if plan is None:
            return "It was chosen by a policy that returns no action values."
        return explain(step.model, plan)


def _scene(scan: KeptScan) -> SceneView:
    eyes, layout = [pose[:3, 3] for pose in scan.viewpoints], scan.layout
    return SceneView(
        scan.entry,
        "",
        np.rint(1000.0 * scan.points).astype(int).ravel().tolist(),
        scan.positions.tolist(),
        [(1000.0 * scan.camera[:3, 3]).round(1).tolist(), scan.camera[:3, 2].round(4).tolist()],
        [(1000.0 * eye).round(1).tolist() if np.isfinite(eye).all() else None for eye in eyes],
        [
            layout.positions,
            *(1000.0 * length for length in (layout.spacing, layout.rim_height, layout.rim_radius)),
        ],
    )


def _why_not_kept(entry: int | None, kept: list[int]) -> str:
    """Say why a scan is not among those kept, given the numbers of their entries in order."""
    if entry is None:
        return "there was no scan before this step"
    if entry < kept[0]:
        latest = "the latest scan" if len(kept) == 1 else f"the latest {len(kept)} scans"
        return f"the cloud of this scan is no longer kept: the run keeps {latest}"
    return "the cloud of this scan is not kept"


def as_json(view: Watched | SceneView) -> dict[str, object]:
    """Return a view as plain data for JSON."""
    return asdict(view)
