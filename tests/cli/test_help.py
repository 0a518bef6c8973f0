"""The help of every command, its example, and suggestions for wrong words."""

import re
import shlex
from argparse import ArgumentParser

import pytest

from beltsort.cli import GROUPS, parser
from beltsort.cli.parser import EXAMPLE

from .running import PAPER, command, output


def commands() -> dict[str, ArgumentParser]:
    """Return the parser of each command."""
    (choices,) = (action.choices for action in parser()._actions if isinstance(action.choices, dict))
    return dict(choices)


NAMES = list(commands())


def test_commands_are_listed_in_groups() -> None:
    text = output("--help")
    headings = re.findall(r"^(\w+):$", text, re.MULTILINE)
    assert headings == ["options", *GROUPS]
    assert re.findall(r"^  ([a-z][\w-]*) {2,}\w", text, re.MULTILINE) == NAMES
    sorting = text.partition("sort:")[2].partition("plan:")[0]
    assert all(f"  {name} " in sorting for name in ("demo", "run", "check", "home", "show", "explain"))


def test_without_a_command_the_help_is_shown() -> None:
    done = command()
    assert done.returncode == 2
    assert done.stderr == output("--help")


@pytest.mark.parametrize("name", NAMES)
def test_help_ends_with_an_example_that_parses(name: str) -> None:
    text = output(name, "--help")
    line = text.partition(f"{EXAMPLE}\n  ")[2].rstrip("\n")
    words = shlex.split(line)
    assert words[:2] == ["beltsort", name]
    assert callable(parser().parse_args(words[1:]).run)


@pytest.mark.parametrize("name", ["info", "plan", "evaluate", "compare", "completion"])
def test_examples_run(name: str) -> None:
    words = shlex.split(output(name, "--help").partition(f"{EXAMPLE}\n  ")[2])
    assert output(*words[1:])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["evalute"], "there is no 'evalute'; did you mean 'evaluate'? Known: demo, run"),
        (["evaluate", PAPER, "--polcy", "despot"], "did you mean --policy for --polcy?"),
        (["info", "--jsn"], "unrecognized arguments: --jsn; did you mean --json for --jsn?"),
        (["viewpoints", "v.json", "--method", "unifrom"], "there is no 'unifrom'; did you mean 'uniform'?"),
    ],
)
def test_wrong_words(arguments: list[str], message: str) -> None:
    done = command(*arguments)
    assert done.returncode == 2
    assert message in done.stderr
    assert done.stderr.startswith("usage: beltsort")
