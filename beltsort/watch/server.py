"""The server of the page: files of the page, and a run as JSON. It listens on this computer only.

Any program and any page of a browser on this computer can reach it. So it answers only requests that name
this computer as their host (a page of another site cannot, also not with a name that it lets point here),
changes nothing without the run's token, and knows its files by name.
"""

import json
import re
import sys
from collections.abc import Callable
from dataclasses import asdict
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from threading import Thread
from types import TracebackType
from typing import Any, Self
from urllib.parse import parse_qs, urlsplit

from beltsort import BeltsortError
from beltsort._core import __version__
from beltsort.errors import JournalError
from beltsort.sorting.holds import Answer, Reply
from beltsort.sorting.requests import Action, Request
from beltsort.watch.watcher import Watcher, as_json

ADDRESS = "127.0.0.1"
SECONDS_PER_REQUEST = 30
FILES = {
    "/": ("index.html", "text/html; charset=utf-8"),
    "/style.css": ("style.css", "text/css; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
    "/scene.js": ("scene.js", "text/javascript; charset=utf-8"),
}
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
ACTIONS: dict[str, Action] = {"/api/hold": "hold", "/api/continue": "continue"}
SETTLE = re.compile(rf"/api/settle/({'|'.join(Answer)})/([0-9]+)")
"""An answer, and the number of the journal entry that asks."""


def request_at(path: str) -> Callable[[Watcher], Request | Reply] | None:
    """Return what asks or answers a run, for the path of a request; None if there is no such path."""
    action, answer = ACTIONS.get(path), SETTLE.fullmatch(path)
    if action is not None:
        return lambda watcher: watcher.request(action)
    if answer is not None:
        return lambda watcher: watcher.settle(Answer(answer[1]), int(answer[2]))
    return None


class WatchServer:
    """Serves the page of one run as long as it is open, from threads of its own.

    Parameters
    ----------
    watcher
        The run.
    port
        Port to listen on; 0: any that is free.

    Raises
    ------
    OSError
        If the port is taken.
    """

    def __init__(self, watcher: Watcher, port: int = 0) -> None:
        self._server = _Server(watcher, port)
        self._thread = Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.1}, daemon=True)

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{ADDRESS}:{self._server.server_port}/"

    def __enter__(self) -> Self:
        """Start to serve."""
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, watcher: Watcher, port: int) -> None:
        super().__init__((ADDRESS, port), _Handler)
        self.watcher = watcher
        self.hosts = {f"{name}:{self.server_port}" for name in (ADDRESS, "localhost")}
        page = files("beltsort.watch") / "page"
        # Read once: nothing that a browser sends becomes a path of a file.
        self.page = {path: ((page / name).read_bytes(), kind) for path, (name, kind) in FILES.items()}

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print nothing for a browser that has closed its connection."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    server_version, sys_version = f"beltsort/{__version__}", ""
    timeout = SECONDS_PER_REQUEST

    def do_GET(self) -> None:
        """Answer with a file of the page, or with JSON."""
        if not self._from_here():
            return
        address = urlsplit(self.path)
        answers: dict[str, Callable[[int | None], dict[str, object]]] = {
            "/api/state": lambda step: as_json(self.server.watcher.state(step)),
            "/api/scene": lambda step: as_json(self.server.watcher.scene(step)),
            "/api/explanation": lambda step: {"text": self.server.watcher.explanation(step or 0)},
        }
        if address.path in self.server.page:
            self._send(HTTPStatus.OK, *self.server.page[address.path])
        elif address.path in answers:
            try:
                numbers = parse_qs(address.query).get("step", [])
                self._json(HTTPStatus.OK, answers[address.path](int(numbers[0]) if numbers else None))
            except JournalError as error:
                self._fail(HTTPStatus.NOT_FOUND, str(error))
            except (BeltsortError, ValueError) as error:
                self._fail(HTTPStatus.BAD_REQUEST, str(error))
        else:
            self._fail(HTTPStatus.NOT_FOUND, "there is no such page")

    def do_POST(self) -> None:
        """Hold or continue the run, or answer its question, if the run's token is given."""
        if not self._from_here():
            return
        make = request_at(self.path)
        scheme, _, token = self.headers.get("Authorization", "").partition(" ")
        if make is None:
            self._fail(HTTPStatus.NOT_FOUND, "there is no such request")
        elif scheme != "Bearer" or not self.server.watcher.may_request(token):
            self._fail(
                HTTPStatus.FORBIDDEN,
                "this needs the run's token: start the run with --allow-hold and open the page with "
                "`beltsort watch RUN --control`",
            )
        else:
            try:
                made = make(self.server.watcher)
            except OSError as error:
                self._fail(HTTPStatus.INSUFFICIENT_STORAGE, f"the request cannot be written: {error}")
            except BeltsortError as error:
                self._fail(HTTPStatus.CONFLICT, str(error))
            else:
                self._json(HTTPStatus.OK, asdict(made))

    def _from_here(self) -> bool:
        """Whether a request names this computer as host, and as origin if it has one; answer it if not."""
        self.close_connection = True
        origin = self.headers.get("Origin")
        hosts = self.server.hosts
        if self.headers.get("Host") in hosts and (origin is None or urlsplit(origin).netloc in hosts):
            return True
        self._fail(HTTPStatus.FORBIDDEN, f"open the page as http://{ADDRESS}:{self.server.server_port}/")
        return False

    def _fail(self, status: HTTPStatus, text: str) -> None:
        self._json(status, {"error": text})

    def _json(self, status: HTTPStatus, content: dict[str, object]) -> None:
        self._send(status, json.dumps(content).encode(), "application/json")

    def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        for name, value in HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Log nothing: the page asks every second."""
