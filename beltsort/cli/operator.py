"""Who answers the questions of a held run on the command line."""

import select
import sys
from pathlib import Path

from beltsort import ArgumentError
from beltsort.cli.output import print_status
from beltsort.sorting.heeding import Check, nothing
from beltsort.sorting.holds import Answer, HeldError, Hold, Reply
from beltsort.sorting.progress import Progress
from beltsort.sorting.requests import read_reply
from beltsort.sorting.settling import may_answer

POLL_INTERVAL = 0.2
"""Time between two looks for an answer from elsewhere, seconds."""


class CommandLineOperator:
    """Answers the questions of a held run: the first with an answer given before, others at the terminal.

    The answer given before is that of `--settle`, or else the one of `beltsort settle` in the journal.

    Parameters
    ----------
    settle
        The option's value.
    broken_off
        Progress of the run that is resumed; None for a new run.
    requests
        The run's folder, in which answers from elsewhere are looked for while a question is asked; None: only
        the terminal is.
    check
        Called again and again while a question is asked, as before each step of the run.

    Raises
    ------
    ArgumentError
        If the run has no question with this answer.
    """

    def __init__(
        self,
        settle: str | None,
        broken_off: Progress | None,
        requests: Path | None = None,
        check: Check = nothing,
    ) -> None:
        self._answer = None if settle is None else Answer(settle)
        self._index = None if broken_off is None else broken_off.index
        if self._answer is not None and (broken_off is None or not may_answer(self._answer, broken_off)):
            raise ArgumentError(
                f"--settle is {settle}, but the run waits for no such answer (it may have been given "
                "already): leave it out"
            )
        if self._answer is None and broken_off is not None:
            self._answer = broken_off.settled
        self._requests, self._check = requests, check

    def __call__(self, hold: Hold) -> Answer | Reply | None:
        """Return the answer to a hold, or raise `HeldError` if there is none."""
        answer, self._answer = self._answer, None
        if answer in hold.answers and hold.object == self._index:
            return answer
        # `beltsort home` drives the belt itself, so this run must end and release it first.
        homing = any(way.home is not None for way in hold.ways)
        if homing or sys.stdin is None or not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise HeldError(hold)
        return ask(hold, self._requests, self._check)


def ask(hold: Hold, requests: Path | None, check: Check) -> Answer | Reply | None:
    """Ask at the terminal which of the hold's ways applies, unless an answer from elsewhere comes first."""
    where = "" if hold.command is None else f" at {hold.command.act}"
    print_status(f"held{where}: {hold.reason}.")
    ways = {"again" if way.answer is None else way.answer.value: way for way in hold.ways}
    for word, way in ways.items():
        print_status(f"    {word}: {way.when}")
    while True:
        print_status(f"Enter {' or '.join(ways)}, or nothing to end the run: ")
        if (reply := wait_for_reply(hold, requests, check)) is not None:
            print_status(f"{reply.answer}, says {reply.by}")
            return reply
        word = sys.stdin.readline().strip().lower()
        if not word:
            raise HeldError(hold)
        if word in ways:
            return ways[word].answer


def wait_for_reply(hold: Hold, requests: Path | None, check: Check) -> Reply | None:
    """Return the answer that comes from elsewhere; None once there is something to read at the terminal."""
    while not select.select([sys.stdin], [], [], POLL_INTERVAL)[0]:
        check()
        reply = None if requests is None else read_reply(requests, hold.question)
        if reply is not None and reply.answer in hold.answers:
            return reply
    return None
