"""`beltsort hold`, `continue` and `stop`: requests to a run that goes on, from another process."""

import time
from argparse import ArgumentParser, Namespace
from dataclasses import asdict
from pathlib import Path

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json
from beltsort.cli.show import add_run
from beltsort.sorting.locks import in_use
from beltsort.sorting.requests import TOKEN, Action, Request, read_token, write_request
from beltsort.sorting.runs import LOCK, folder_of
from beltsort.sorting.status import status_of

WAIT_INTERVAL = 0.2
"""Time between two looks whether a run has ended, seconds."""


def add_request(
    subparsers: Subparsers, action: Action, help: str, description: str, effect: str
) -> ArgumentParser:
    """Add the command that makes a request, and return its parser.

    Parameters
    ----------
    subparsers
        Of all commands.
    action
        The request, and the command's name.
    help, description
        The command's.
    effect
        What the run does then, in words.
    """
    parser = subparsers.add_parser(
        action,
        help=help,
        description=f"{description} The run must have been started with --allow-hold, by the same user. "
        "docs/service.md describes it.",
    )
    add_run(parser)
    add_json(parser)
    parser.set_defaults(run=run, action=action, effect=effect, wait=False)
    return parser


def run(arguments: Namespace) -> int:
    """Leave the request, and wait until the run has ended if that is wanted."""
    action: Action = arguments.action
    folder = folder_of(arguments.folder)
    check_takes_requests(folder)
    request = Request.now(action, f"beltsort {action}")
    write_request(folder, request)
    while arguments.wait and in_use(folder / LOCK):
        time.sleep(WAIT_INTERVAL)
    if arguments.json:
        print_json({"run": str(folder), **asdict(request)})
    else:
        print(f"{folder} {arguments.effect}")
    return 0


def check_takes_requests(folder: Path) -> None:
    """Raise an `ArgumentError` unless a run goes on and takes requests of this user."""
    status = status_of(folder)
    if not in_use(folder / LOCK):
        raise ArgumentError(f"{folder} does not go on; `beltsort status {folder}` says how to resume it")
    if status.question is not None:
        raise ArgumentError(f"{folder} waits for an answer; `beltsort status {folder}` says for which")
    if read_token(folder) is None:
        raise ArgumentError(
            f"{folder / TOKEN} cannot be read: start the run with --allow-hold, as the same user"
        )
