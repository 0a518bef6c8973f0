"""The node of a run: a listener of its journal, and requests of other nodes to hold and continue it."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from queue import Full, Queue
from threading import Lock, Thread
from types import TracebackType
from typing import Self

from beltsort.cell.protocols import Scan
from beltsort.drivers.ros.process import NodeProcess
from beltsort.drivers.ros2.link import node_program
from beltsort.errors import CellError
from beltsort.ros2.markers import MARKERS, Scene, SeenScan, markers_of
from beltsort.ros2.messages import BELIEF, DECISION, STATE, Published, RunMessages
from beltsort.ros2.options import NodeOptions
from beltsort.sorting.entries import Scanned, StateChanged
from beltsort.sorting.journal import Entry
from beltsort.sorting.perceived import PerceivedPosition
from beltsort.sorting.progress import Progress
from beltsort.sorting.requests import Action, Request, takes_requests, write_request

PROGRAM = "beltsort.ros2.node"
QUEUED = 1000
"""Number of entries that may wait for the node."""
START_TIMEOUT, PUBLISH_TIMEOUT, END_TIMEOUT = 30.0, 5.0, 3.0
"""Timeouts of the node's start, of each message, and of the last messages of a run, seconds."""
REQUEST_WAIT, GRACE = 2.0, 3.0
"""Time for which the node waits for a request before it answers, and what the answer may take longer, s."""

Parameter = str | int | list[str]


@dataclass(frozen=True)
class RunDescription:
    """What the node of a run is told.

    Attributes
    ----------
    folder
        Folder of the run, in which requests are left.
    parameters
        The node's read-only parameters.
    scene
        Belt and viewpoints.
    labels
        Names of the model's labels.
    broken_off
        Progress of the run that is resumed; None for a new run.
    """

    folder: Path
    parameters: Mapping[str, Parameter]
    scene: Scene
    labels: Sequence[str]
    broken_off: Progress | None = None


class RunNode:
    """Publishes a run on ROS 2, and leaves requests of other nodes in its folder.

    A listener of the journal that never delays or ends the run: entries wait in a queue for a thread that
    starts the node and publishes. A node that does not start, has ended, or falls behind is told once, and
    given up.

    Parameters
    ----------
    options
        Those of the cell file.
    run
        The run.
    say
        Called with a line if the node is given up; from another thread.
    """

    def __init__(self, options: NodeOptions, run: RunDescription, say: Callable[[str], None]) -> None:
        self._options, self._run, self._say = options, run, say
        self._queue: Queue[Entry | SeenScan | None] = Queue(QUEUED)
        self._messages = RunMessages()
        if run.broken_off is not None:
            self._messages.resume(run.broken_off)
        self._ending, self._given_up, self._telling = False, False, Lock()
        self._process: NodeProcess | None = None
        self._seen: SeenScan | None = None
        self._thread = Thread(target=self._work, name="ros2", daemon=True)

    def __enter__(self) -> Self:
        """Start the node; the run does not wait for it."""
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the node, once it has published what there is, or after `END_TIMEOUT`."""
        self._ending = True
        with suppress(Full):
            self._queue.put_nowait(None)
        self._thread.join(END_TIMEOUT)
        if self._thread.is_alive() and self._process is not None:
            self._given_up = True
            self._process.end(patience=0.0)

    @property
    def process_id(self) -> int | None:
        """Id of the node's process; None until it runs."""
        return None if self._process is None else self._process.process_id

    def __call__(self, entry: Entry) -> None:
        """Let an entry be published."""
        self._put(entry)

    def scanned(self, entry: Entry, scan: Scan, perceived: Sequence[PerceivedPosition]) -> None:
        """Let the candidates of a scan be shown."""
        if isinstance(entry.content, Scanned):
            self._put(SeenScan.of(entry.content, scan, perceived))

    def _put(self, what: Entry | SeenScan) -> None:
        if self._given_up:
            return
        try:
            self._queue.put_nowait(what)
        except Full:
            self._give_up(f"{QUEUED} entries of the journal wait for it")

    def _work(self) -> None:
        try:
            process = self._process = self._started()
        except Exception as failure:  # any exception: the run goes on without the node
            self._give_up(failure)
            return
        Thread(target=self._take_requests, args=[process], name="ros2-requests", daemon=True).start()
        try:
            self._send(process, self._markers(None))
            while not self._given_up and (what := self._queue.get()) is not None:
                if isinstance(what, SeenScan):
                    self._seen = what
                    self._send(process, self._markers(what))
                else:
                    self._publish(process, what)
        except Exception as failure:  # likewise
            self._give_up(failure)
        process.end()

    def _started(self) -> NodeProcess:
        setup = {
            "name": self._options.name,
            "publish": [list(topic) for topic in (STATE, BELIEF, DECISION, MARKERS)],
            "parameters": dict(self._run.parameters),
        }
        return NodeProcess(node_program(self._options, PROGRAM), setup, START_TIMEOUT)

    def _publish(self, process: NodeProcess, entry: Entry) -> None:
        for published in self._messages.read(entry):
            self._send(process, published)
        if self._messages.moved > 0 and self._seen is not None:
            self._seen = replace(self._seen, moved=self._seen.moved + self._messages.moved)
            self._send(process, self._markers(self._seen))
        if isinstance(entry.content, StateChanged):
            process.ask("follow", PUBLISH_TIMEOUT, held=self._messages.held)

    def _markers(self, seen: SeenScan | None) -> Published:
        return markers_of(self._run.scene, self._options.frame, self._run.labels, seen)

    def _send(self, process: NodeProcess, published: Published) -> None:
        process.ask("publish", PUBLISH_TIMEOUT, topic=published.topic, message=published.message)

    def _take_requests(self, process: NodeProcess) -> None:
        """Do what other nodes ask for, as long as the node lives; the other thread tells of its end."""
        with suppress(CellError):
            while not (self._ending or self._given_up):
                found = process.ask("next_request", REQUEST_WAIT + GRACE, wait=REQUEST_WAIT).values
                if found["action"]:
                    refusal = self._request(found["action"])
                    process.ask("answer", PUBLISH_TIMEOUT, asked=found["asked"], refusal=refusal)

    def _request(self, action: Action) -> str:
        """Leave a request for the run; return why it is refused, empty if it is not."""
        if not takes_requests(self._run.folder):
            return "it takes no requests; start it with --allow-hold"
        if self._messages.question is not None:
            return "it waits for an answer; `beltsort status` says for which"
        try:
            write_request(self._run.folder, Request.now(action, f"ROS 2 node {self._options.name}"))
        except OSError as reason:
            return str(reason)
        return ""

    def _give_up(self, reason: object) -> None:
        """Say once that the run goes on without the node."""
        with self._telling:
            if self._given_up or self._ending:
                return
            self._given_up = True
        self._say(f"the run is no longer published on ROS 2 ({reason}); it goes on")
