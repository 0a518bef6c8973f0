"""`beltsort watch`: show a run on a page in the browser."""

import os
import sys
import threading
from argparse import Namespace
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status
from beltsort.cli.show import add_run

if TYPE_CHECKING:
    from beltsort.watch import Watcher

LARGEST_PORT = 65_535
NICENESS = 10
"""Added to the process's own, so that explaining plans takes no time from a run on the same computer."""

EXAMPLE = "beltsort watch runs/2026-01-31T12-00-00.000000Z"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "watch",
        help="show a run on a page in the browser",
        description="Show a run, which may still be in progress, on a page in the browser of this computer, "
        "until Ctrl-C. The run's journal is read and never written. docs/watch.md describes the page.",
    )
    add_run(parser)
    parser.add_argument(
        "--port", type=int, default=0, metavar="N", help="port on 127.0.0.1 (default: any that is free)"
    )
    parser.add_argument("--no-browser", action="store_true", help="print the page's address, open no browser")
    parser.add_argument(
        "--control",
        action="store_true",
        help="open the page with the token of a run that was started with --allow-hold: whoever has this "
        "page can hold and continue the run",
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Serve the page until the process is interrupted."""
    import webbrowser

    from beltsort.watch import Watcher, WatchServer

    if not 0 <= arguments.port <= LARGEST_PORT:
        raise ArgumentError(f"--port is {arguments.port}, expected 0 to {LARGEST_PORT}; leave it out for any")
    watcher = Watcher(arguments.folder)
    token = f"#token={control_token(watcher)}" if arguments.control else ""
    server = WatchServer(watcher, arguments.port)
    os.nice(NICENESS)
    with server:
        address = f"{server.url}{token}"
        if arguments.json:
            print_json({"address": address, "run": str(watcher.folder)})
            sys.stdout.flush()
        else:
            print(f"{watcher.folder} on {address}", flush=True)
        if not arguments.no_browser and has_screen():
            webbrowser.open(address)
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            print_status("beltsort: the page is closed, the run is not")
    return 0


def control_token(watcher: "Watcher") -> str:
    """Return the token of the run.

    Raises
    ------
    ArgumentError
        If it has none, or this user may not read it.
    """
    from beltsort.sorting.requests import TOKEN, read_token

    token = read_token(watcher.folder)
    if token is None:
        raise ArgumentError(
            f"--control needs {watcher.folder / TOKEN}, which cannot be read: start the run with "
            "`beltsort run --allow-hold`, as the same user, or leave --control out"
        )
    return token


def has_screen() -> bool:
    """Whether a browser can open a window; `webbrowser` would otherwise take one for terminals."""
    return sys.platform in ("darwin", "win32") or bool({"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys())
