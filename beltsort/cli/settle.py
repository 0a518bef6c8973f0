"""`beltsort settle`: answer the question of a held run."""

from argparse import Namespace
from dataclasses import asdict

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status
from beltsort.cli.show import add_run
from beltsort.sorting.holds import Answer
from beltsort.sorting.runs import folder_of
from beltsort.sorting.settling import settle
from beltsort.sorting.status import status_of

EXAMPLE = "beltsort settle latest done"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "settle",
        help="answer the question of a held run",
        description="Answer the question of a held run, after you have looked at the cell. The answer is "
        "kept in the journal with your name, and used when the run is resumed; a run that waits at its "
        "terminal and was started with --allow-hold takes it at once. `beltsort status` prints the question.",
    )
    add_run(parser)
    parser.add_argument(
        "answer",
        choices=[answer.value for answer in Answer],
        help="the answer, as `beltsort status` prints it",
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Give the answer."""
    from beltsort.cli.status import resume_line

    folder = folder_of(arguments.folder)
    reply = settle(folder, Answer(arguments.answer), "beltsort settle")
    waits = status_of(folder).pid is not None
    if arguments.json:
        print_json({"run": str(folder), **asdict(reply)})
    else:
        print(f"{folder}: {reply.answer}, says {reply.by}")
    if not waits:
        print_status(f"beltsort: to resume: {resume_line(folder)}")
    return 0
