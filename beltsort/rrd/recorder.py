"""The recorder of a run: a listener of its journal and a watcher of its scans."""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from beltsort import SortingModel
from beltsort.cell.bins import REJECT
from beltsort.cell.protocols import Cell, Scan
from beltsort.errors import RecordingError
from beltsort.planning.decisions import right_bins
from beltsort.rrd import scene
from beltsort.rrd.blueprint import arranged
from beltsort.rrd.package import load_rerun
from beltsort.sorting.entries import Chosen, Decided, Planned, Scanned, Skipped, StateChanged
from beltsort.sorting.journal import Entry
from beltsort.sorting.kept_scans import TellsCandidate
from beltsort.sorting.perceived import PerceivedPosition
from beltsort.util.text import position_number

APPLICATION = "beltsort"
PATIENCE = 10.0  # seconds; longest wait for the file at the end

TrueClass = Callable[[int], int | None]
"""From the number of an object to its class, None for an empty cup."""


class Recorder:
    """Writes a recording of one run; timelines are `step` (planner steps), `object` and `time`.

    A recorder that fails says so once and records nothing more; the run goes on.

    Parameters
    ----------
    path
        The file (.rrd), which is overwritten.
    cell
        The cell.
    model
        The model of the run.
    say
        Called with a line if the recorder fails.
    true_class
        If given, the log says which decisions were wrong.

    Raises
    ------
    RecordingError
        If rerun is not installed, or the file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        cell: Cell,
        model: SortingModel,
        say: Callable[[str], None],
        true_class: TrueClass | None = None,
    ) -> None:
        self._rerun = load_rerun()
        self._path, self._cell, self._model = path, cell, model
        self._say, self._true_class = say, true_class
        self._step, self._failed = 0, False
        self._belief = np.tile(model.arrival, (model.positions, 1))  # (H, L)
        try:
            path.open("wb").close()
        except OSError as reason:
            raise RecordingError(
                f"the recording {path} cannot be written ({reason}); name a file in a folder that "
                "can be written"
            ) from reason
        self._stream = self._rerun.RecordingStream(APPLICATION, recording_id=uuid4())
        self._stream.set_log_tick_enabled(False)
        self._stream.set_log_time_enabled(False)
        self._stream.save(path, default_blueprint=arranged(self._rerun, model.positions))
        self._attempt(self._begin)

    def __call__(self, entry: Entry) -> None:
        """Record an entry of the journal."""
        self._attempt(lambda: self._entry(entry))

    def scanned(self, entry: Entry, scan: Scan, perceived: Sequence[PerceivedPosition]) -> None:
        """Record a scan, in the belt frame, and the candidates in it; its entry has been recorded before."""
        self._attempt(lambda: self._scan(entry, scan, perceived))

    def close(self) -> None:
        """Finish the file."""
        self._attempt(self._finish)

    def __enter__(self) -> Self:
        """Use the recorder as a context that closes it."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()

    def _attempt(self, record: Callable[[], None]) -> None:
        """Record something, unless the recorder has failed; the run never fails by it."""
        if self._failed:
            return
        try:
            record()
        except Exception as failure:  # any exception: the run must go on
            self._failed = True
            self._say(f"the recording {self._path} ends here ({failure!r}); the run goes on without it")

    def _begin(self) -> None:
        rerun, model = self._rerun, self._model
        for entity, content in scene.fixed(rerun, self._cell):
            self._stream.log(entity, *content, static=True)
        colours = [scene.class_colour(i) for i in range(len(model.classes))]
        for j in range(model.positions):
            lines = rerun.SeriesLines(
                colors=colours, names=list(model.classes), interpolation_mode="StepAfter"
            )
            self._stream.log(f"belief/position_{position_number(j)}", lines, static=True)
        self._stream.set_time("step", sequence=0)
        self._beliefs(self._belief)

    def _finish(self) -> None:
        self._stream.flush(timeout_sec=PATIENCE)
        self._stream.disconnect()

    def _entry(self, entry: Entry) -> None:
        self._stream.set_time("time", timestamp=datetime.fromisoformat(entry.time))
        if entry.object is not None:
            self._stream.set_time("object", sequence=entry.object)
        match entry.content:
            case Planned() as plan:
                self._plan(plan)
            case Chosen(why=str(why)):
                self._log(f"rule: {why}", "WARN")
            case Scanned() as scan:
                self._count()
                self._beliefs(np.asarray(scan.belief))
                seen = ", ".join(self._seen(scan, j) for j in range(len(scan.labels)))
                self._log(f"look from {self._model.viewpoints[scan.viewpoint]}: {seen}")
            case Decided() as decided:
                self._count()
                self._decision(decided, entry.object)
                self._advanced()
            case Skipped():
                self._log("an empty cup")
                self._advanced()
            case StateChanged(state, reason):
                self._log(f"{state}: {reason}")

    def _count(self) -> None:
        """Begin the next planner step; a scan and a decision take one each."""
        self._step += 1
        self._stream.set_time("step", sequence=self._step)

    def _scan(self, entry: Entry, scan: Scan, perceived: Sequence[PerceivedPosition]) -> None:
        rerun, content = self._rerun, entry.content
        if not isinstance(content, Scanned):
            return
        for entity, archetypes in scene.camera(rerun, scan):
            self._stream.log(entity, *archetypes)
        for j, (seen, label) in enumerate(zip(perceived, content.labels, strict=True)):
            points = seen.points if isinstance(seen, TellsCandidate) else None
            colour = scene.rgb(scene.GREY) if label is None else scene.class_colour(label)
            cloud = scene.candidate(rerun, points, colour)
            self._stream.log(f"world/candidates/position_{position_number(j)}", cloud)
        names = [self._seen(content, j) for j in range(len(content.labels))]
        self._stream.log("world/labels", scene.names_above(rerun, self._cell.layout, names))

    def _beliefs(self, belief: NDArray[np.float64]) -> None:
        """Record a belief, shape (H, L)."""
        self._belief = belief
        for j, row in enumerate(belief):
            self._stream.log(f"belief/position_{position_number(j)}", self._rerun.Scalars(row))

    def _advanced(self) -> None:
        """Record what is believed after the belt has advanced: a new object is at the last position."""
        self._beliefs(np.vstack([self._belief[1:], self._model.arrival]))

    def _plan(self, plan: Planned) -> None:
        """Record the value of each action, a curve for each."""
        for option in plan.values:
            curve = f"plan/{self._action(option)}"
            self._stream.log(curve, self._rerun.Scalars([option["value"]]))
        for name, value in (("lower bound", plan.lower), ("upper bound", plan.upper)):
            self._stream.log(f"plan/{name.replace(' ', '_')}", self._rerun.Scalars([value]))

    def _decision(self, decided: Decided, number: int | None) -> None:
        """Record a decision in the log, with whether it is right if that is known."""
        model = self._model
        name = REJECT if decided.label is None else model.bins[decided.label]
        text = f"object {number}: decide {name} (belief {decided.belief:.3f}, looks: {decided.looks})"
        true = None if self._true_class is None or number is None else self._true_class(number)
        if true is None:
            self._log(text)
        elif decided.label is not None and right_bins(model)[decided.label, true]:
            self._log(f"{text}, right")
        else:
            self._log(f"{text}, wrong: it is {model.classes[true]}", "ERROR")

    def _log(self, text: str, level: str = "INFO") -> None:
        self._stream.log("log", self._rerun.TextLog(text, level=level))

    def _seen(self, scan: Scanned, position: int) -> str:
        label = scan.labels[position]
        return scan.findings[position] if label is None else self._model.labels[label]

    def _action(self, option: Mapping[str, Any]) -> str:
        """Return the name of an entity for an action of a plan."""
        if "move" in option:
            return f"look_from_{self._model.viewpoints[option['move']]}"
        return f"decide_{self._model.bins[option['decide']]}"
