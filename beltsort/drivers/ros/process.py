"""The process in which a node program runs, its requests and answers."""

import json
import os
import socket
import subprocess
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, wait
from contextlib import suppress
from itertools import count
from multiprocessing.connection import Connection
from threading import Lock, Thread
from typing import Any, NamedTuple

from beltsort.cell.commands import CommandError, Outcome
from beltsort.errors import CellError


class Program(NamedTuple):
    """A node program: its command, environment, and what it needs with the remedy if that is missing."""

    command: Sequence[str]
    environment: Mapping[str, str]
    needs: str
    remedy: str


class Answer(NamedTuple):
    """An answer of the node: plain values, and the bytes of a point cloud."""

    values: dict[str, Any]
    data: bytes


class NodeProcess:
    """A running node.

    Parameters
    ----------
    program
        The node program; the number of a socket's file descriptor is its last argument.
    setup
        The node's name, its topics and their types, and its use of tf.
    timeout
        Timeout of the start, seconds.

    Raises
    ------
    CommandError
        `NOT_DONE` if it does not start in time, or something that it needs is missing.
    """

    def __init__(self, program: Program, setup: dict[str, Any], timeout: float) -> None:
        self.name: str = setup["name"]
        ours, theirs = socket.socketpair()
        with theirs:
            self._process = subprocess.Popen(
                [*program.command, str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                env=program.environment,
                start_new_session=True,  # keeps the node alive on Ctrl-C, to stop devices
            )
        self._connection = Connection(ours.detach())
        self._sending, self._numbers = Lock(), count(1)
        ready: Future[Answer] = Future()
        self._waiting: dict[int, Future[Answer]] = {0: ready}
        Thread(target=self._receive, name=self.name, daemon=True).start()
        try:
            self.started = self._started(setup, ready, timeout)
        except BaseException:
            self.end(patience=0.0)
            raise
        if "missing" in self.started:
            self.end()
            raise CommandError(
                f"{program.needs}, which cannot be loaded ({self.started['missing']}); {program.remedy}",
                Outcome.NOT_DONE,
            )

    def _started(self, setup: dict[str, Any], ready: "Future[Answer]", timeout: float) -> dict[str, Any]:
        try:
            self._send(setup)
            return self._result(ready, timeout, "starting").values
        except CommandError as reason:
            raise CommandError(f"{reason}; connect() has a longer timeout", Outcome.NOT_DONE) from reason

    @property
    def process_id(self) -> int:
        """Id of the process."""
        return self._process.pid

    def alive(self) -> bool:
        """Return whether the process runs."""
        return not self._connection.closed and self._process.poll() is None

    def ask(self, request: str, timeout: float, **arguments: Any) -> Answer:
        """Send a request and return its answer; a late answer is discarded."""
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
        """Close the socket, which ends the process; kill it if it does not end within `patience` seconds."""
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
            # Unknown, since the request may be one about a command that was sent before.
            raise CommandError(f"the ROS node {self.name} has ended; try again", Outcome.UNKNOWN) from reason

    def _receive(self) -> None:
        try:
            while True:
                values = json.loads(self._connection.recv_bytes())
                data = self._connection.recv_bytes()
                future = self._waiting.get(values.pop("id"))
                if future is not None:
                    future.set_result(Answer(values, data))
        except (EOFError, OSError):
            # Closed first: who is told that the node has ended must not find it alive.
            with self._sending:
                self._connection.close()
            for future in list(self._waiting.values()):
                if not future.done():
                    future.set_exception(EOFError("its process ended"))

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
                f"the ROS node {self.name} ended during a request ({what}), expected an answer; see standard "
                "error for the reason, and try again",
                Outcome.UNKNOWN,
            ) from reason
