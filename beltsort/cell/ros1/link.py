"""The way to a node in another process: requests, deadlines, and starting it anew."""

import json
import os
import socket
import subprocess
import sys
import time
from concurrent.futures import Future, wait
from contextlib import suppress
from itertools import count
from multiprocessing.connection import Connection
from threading import Lock, RLock, Thread
from typing import Any, NamedTuple
from uuid import uuid4

from beltsort.cell.commands import CommandError, Outcome
from beltsort.cell.ros1.master import Master
from beltsort.cell.ros1.options import Ros1Options
from beltsort.errors import CellError

MASTER_TIMEOUT = 2.0
"""Seconds that the master may take to answer."""

START_TIMEOUT = 20.0
"""Seconds for a new node: rospy takes one on an idle computer."""

GRACE = 0.5
"""Seconds by which an answer may pass a deadline that the node itself keeps."""

PACKAGES = "on Debian, run scripts/bootstrap, or sudo apt-get install python3-rospy python3-tf2-msgs"


class Answer(NamedTuple):
    """What the node said: plain values, and the bytes of a point cloud."""

    values: dict[str, Any]
    data: bytes


class Link:
    """One ROS 1 node, started when it is first needed and again when it or the master was restarted.

    Parameters
    ----------
    options
        Where the ROS 1 system is.
    role
        Part of the node's name.
    publish, subscribe
        Message type of each topic.
    tf
        Whether to listen to tf.
    pose_age
        How far from the time asked for a transform may be, seconds.
    """

    def __init__(
        self,
        options: Ros1Options,
        role: str,
        *,
        publish: dict[str, str] | None = None,
        subscribe: dict[str, str] | None = None,
        tf: bool = False,
        pose_age: float = 0.2,
    ) -> None:
        self.master = Master(options.master)
        self._options, self._role = options, role
        self._setup = {"publish": publish or {}, "subscribe": subscribe or {}, "tf": tf, "pose_age": pose_age}
        self._lock = RLock()
        self._process: NodeProcess | None = None

    def connect(self, timeout: float = START_TIMEOUT) -> None:
        """See to it that the node runs and the master knows it, in time.

        Raises
        ------
        CommandError
            `NOT_DONE` if the master does not answer, or the node does not start.
        CellError
            If rospy is missing.
        """
        with self._lock:
            running, asking = self._process, min(MASTER_TIMEOUT, timeout)
            if running is None or not running.alive() or not self._known(running, asking):
                self.close()
                deadline = Deadline(timeout)
                self.master.identity(asking)  # rospy waits for a master without end
                name = f"beltsort_{self._role}_{uuid4().hex[:8]}"
                self._process = NodeProcess(self._options, {**self._setup, "name": name}, deadline.left())

    def ask(self, request: str, timeout: float, **arguments: Any) -> Answer:
        """Ask the node; connect first.

        Raises
        ------
        CommandError
            `UNKNOWN` if it does not answer in time, or died.
        CellError
            What the node refused, in its words.
        """
        process = self._process
        if process is None:
            raise CommandError(
                f"the ROS node {self._role!r} is not connected; call connect()", Outcome.NOT_DONE
            )
        return process.ask(request, timeout, **arguments)

    def newest(
        self, topic: str, deadline: "Deadline", *, after: int = 0, wait: float = 0.0, not_before: float = 0.0
    ) -> Answer:
        """Return the newest message of `topic` beyond number `after`; its "message" is None if none came.

        Waits for it, at most to the deadline. A message with a stamp earlier than `not_before` comes without
        its bytes.
        """
        left = deadline.left()
        asked = {"topic": topic, "after": after, "wait": min(wait, left), "not_before": not_before}
        return self.ask("newest", left + GRACE, **asked)

    def close(self) -> None:
        """End the node."""
        with self._lock:
            if self._process is not None:
                self._process.end()
                self._process = None

    def _known(self, process: "NodeProcess", timeout: float) -> bool:
        return self.master.node_uri(f"/{process.name}", timeout) == process.uri


class NodeProcess:
    """The process in which rospy runs."""

    def __init__(self, options: Ros1Options, setup: dict[str, Any], timeout: float) -> None:
        self.name: str = setup["name"]
        ours, theirs = socket.socketpair()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "beltsort.cell.ros1.node", str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                env=_environment(options),
            )
        self._connection = Connection(ours.detach())
        self._sending, self._numbers = Lock(), count(1)
        ready: Future[Answer] = Future()
        self._waiting: dict[int, Future[Answer]] = {0: ready}
        Thread(target=self._receive, name=self.name, daemon=True).start()
        try:
            self._send(setup)
            started = self._started(ready, timeout)
        except BaseException:
            self.end(patience=0.0)
            raise
        if "missing" in started:
            self.end()
            raise CellError(f"ROS 1 needs rospy, which cannot be loaded ({started['missing']}); {PACKAGES}")
        self.uri: str = started["uri"]

    def _started(self, ready: "Future[Answer]", timeout: float) -> dict[str, Any]:
        try:
            return self._result(ready, timeout, "starting").values
        except CommandError as reason:
            raise CommandError(f"{reason}; connect() waits as long as it takes", Outcome.NOT_DONE) from reason

    def alive(self) -> bool:
        """Tell whether the process runs."""
        return not self._connection.closed and self._process.poll() is None

    def ask(self, request: str, timeout: float, **arguments: Any) -> Answer:
        """Send a request and wait for its answer; one that is late is dropped."""
        number, future = next(self._numbers), Future[Answer]()
        self._waiting[number] = future
        try:
            self._send({"number": number, "name": request, **arguments})
            answer = self._result(future, timeout, request)
        finally:
            self._waiting.pop(number, None)
        if "error" in answer.values:
            raise CellError(answer.values["error"])
        return answer

    def end(self, patience: float = 2.0) -> None:
        """Close the socket, with which the process ends; kill it if it does not in `patience` seconds."""
        with suppress(OSError):
            socket.socket(fileno=os.dup(self._connection.fileno())).shutdown(socket.SHUT_RDWR)
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _send(self, message: dict[str, Any]) -> None:
        try:
            with self._sending:
                self._connection.send_bytes(json.dumps(message).encode())
        except OSError as reason:
            raise CommandError(f"the ROS node {self.name} has ended; try again", Outcome.NOT_DONE) from reason

    def _receive(self) -> None:
        try:
            while True:
                values = json.loads(self._connection.recv_bytes())
                data = self._connection.recv_bytes()
                future = self._waiting.get(values.pop("id"))
                if future is not None:
                    future.set_result(Answer(values, data))
        except (EOFError, OSError):
            for future in list(self._waiting.values()):
                if not future.done():
                    future.set_exception(EOFError("its process ended"))
        self._connection.close()

    def _result(self, future: Future[Answer], timeout: float, what: str) -> Answer:
        wait([future], timeout)
        if not future.done():
            raise CommandError(
                f"the ROS node {self.name} did not answer ({what}) within {timeout:.3g} s; try again",
                Outcome.UNKNOWN,
            )
        try:
            return future.result()
        except EOFError as reason:
            raise CommandError(
                f"the ROS node {self.name} ended while it was asked ({what}); its last words are on standard "
                "error, try again",
                Outcome.UNKNOWN,
            ) from reason


class Deadline:
    """What is left of a timeout.

    Examples
    --------
    >>> Deadline(10.0).left() <= 10.0
    True
    """

    def __init__(self, timeout: float) -> None:
        self._end = time.monotonic() + timeout

    def left(self) -> float:
        """Return the seconds that are left, 0 when it is over."""
        return max(0.0, self._end - time.monotonic())


def _environment(options: Ros1Options) -> dict[str, str]:
    """Return the environment of a node: our packages, and where ROS is."""
    path = os.pathsep.join(entry or os.curdir for entry in sys.path)
    ros = {"ROS_MASTER_URI": options.master, "ROS_IP": options.address, "ROS_HOSTNAME": options.address}
    return {**os.environ, "PYTHONPATH": path, **ros}
