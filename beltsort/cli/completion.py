"""`beltsort completion`: completion of commands, options, models, policies and files by the shell."""

import os
from argparse import Action, ArgumentParser, Namespace, _SubParsersAction
from collections.abc import Callable, Iterator

from beltsort import models
from beltsort.cli.arguments import Subparsers
from beltsort.planning.named_policy import KINDS

EXAMPLE = "beltsort completion bash"
SHELLS = ("bash", "zsh", "fish")
WANTED = "_ARGCOMPLETE"
"""The shell sets this variable when it asks for completions."""


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "completion",
        help="print a script with which the shell completes commands",
        description='Print a script for completion. bash: put eval "$(beltsort completion bash)" into '
        "~/.bashrc. zsh: the same with zsh, into ~/.zshrc, after compinit. fish: beltsort completion fish > "
        "~/.config/fish/completions/beltsort.fish",
    )
    parser.add_argument("shell", choices=SHELLS, help="the shell")
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Print the script."""
    from argcomplete.shell_integration import shellcode

    print(shellcode(["beltsort"], shell=arguments.shell))
    return 0


def wanted() -> bool:
    """Whether the shell asks for completions, rather than for a command."""
    return WANTED in os.environ


def complete(parser: ArgumentParser) -> None:
    """Answer the shell, and exit."""
    import argcomplete
    from argcomplete.completers import FilesCompleter

    files = FilesCompleter()
    for action in _actions(parser):
        if action.dest == "model":
            names = list(models.PACKAGED)
        elif action.dest in ("policy", "policies", "baseline"):
            names = list(KINDS)
        else:
            continue
        vars(action)["completer"] = _with_files(names, files)  # where argcomplete looks for it
    argcomplete.autocomplete(parser, default_completer=files)


def _actions(parser: ArgumentParser) -> Iterator[Action]:
    for action in parser._actions:
        yield action
        if isinstance(action, _SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)


def _with_files(names: list[str], files: Callable[..., list[str]]) -> Callable[..., list[str]]:
    return lambda prefix, **_: [*(name for name in names if name.startswith(prefix)), *files(prefix)]
