"""The command line: one file per command.

Each command's file defines `EXAMPLE`, a command line, and `add_parser(subparsers)`, which sets the parser's
default `run`: a function of the arguments that returns the exit code. Results are printed on standard output,
everything else on standard error.
"""

import os
import select
import shlex
import signal
import sys
from collections.abc import Sequence

from beltsort import BeltsortError, __version__
from beltsort.cell.commands import CommandError, EmergencyStopError
from beltsort.cellfile.problems import CellFileError
from beltsort.cli import (
    backup,
    calibrate_belt,
    calibrate_check,
    check,
    classify,
    compare,
    completion,
    demo,
    estimate,
    evaluate,
    example,
    exit_codes,
    explain,
    export,
    go_on,
    hold,
    home,
    info,
    migrate,
    plan,
    prepare,
    prune,
    reproduce,
    run,
    service,
    settle,
    show,
    solve,
    status,
    stop,
    sweep,
    throughput,
    train,
    viewpoints,
    watch,
)
from beltsort.cli.output import warnings_on_lines
from beltsort.cli.parser import Parser, add_commands
from beltsort.errors import InUseError, JournalNotWrittenError
from beltsort.sorting.interrupts import Interrupted

GROUPS = {
    "sort": (demo, run, example, check, home, show, watch, explain, backup, prune, migrate),
    "serve": (service, status, hold, go_on, stop, settle),
    "plan": (plan, evaluate, compare, throughput, sweep, solve, export, info),
    "perceive": (train, classify, estimate, prepare, viewpoints, calibrate_belt, calibrate_check),
    "paper": (reproduce,),
    "shell": (completion,),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv
        Arguments without the program's name; default those of the process.

    Returns
    -------
    int
        Exit code, one of `beltsort.cli.exit_codes`.
    """
    given = sys.argv[1:] if argv is None else list(argv)
    commands = parser()
    if completion.wanted():
        completion.complete(commands)
    if not given:
        commands.print_help(sys.stderr)
        return exit_codes.WRONG
    try:
        arguments = commands.parse_args(given)
        arguments.command_line = shlex.join(["beltsort", *given])
        with warnings_on_lines():
            code: int = arguments.run(arguments)
            sys.stdout.flush()
    except BrokenPipeError as error:
        if not _stdout_closed():
            return _failed(error)
        return exit_codes.SIGNALLED + signal.SIGPIPE
    except CellFileError as error:  # one line for each problem
        print(f"beltsort: error: {arguments.cell} is not a valid cell file:\n{error}", file=sys.stderr)
        return exit_codes.WRONG
    except (BeltsortError, OSError, OverflowError) as error:
        return _failed(error)
    except KeyboardInterrupt as interrupt:
        number = interrupt.signal if isinstance(interrupt, Interrupted) else signal.SIGINT
        return exit_codes.SIGNALLED + number
    return code


def _failed(error: Exception) -> int:
    print("beltsort: error:", " ".join(str(error).split()), file=sys.stderr)
    return code_of(error)


def _stdout_closed() -> bool:
    """Return whether whoever read standard output has left; then nothing more is written there."""
    number = sys.stdout.fileno()
    pipe = select.poll()
    pipe.register(number, 0)  # errors are always told
    if not any(event & select.POLLERR for _, event in pipe.poll(0)):
        return False
    os.dup2(os.open(os.devnull, os.O_WRONLY), number)  # for the flush at exit
    return True


def code_of(error: Exception) -> int:
    """Return the exit code of an error."""
    match error:
        case EmergencyStopError():
            return exit_codes.EMERGENCY_STOP
        case CommandError():
            return exit_codes.TRY_AGAIN
        case JournalNotWrittenError():
            return exit_codes.NOT_WRITTEN
        case InUseError():
            return exit_codes.IN_USE
    return exit_codes.WRONG


def parser() -> Parser:
    """Return the parser of all commands."""
    top = Parser("beltsort", description="Sort objects from a conveyor belt by active perception.")
    top.add_argument("--version", action="version", version=f"beltsort {__version__}")
    add_commands(top, GROUPS)
    return top
