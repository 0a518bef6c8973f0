"""Pages of the commands, written from the parsers of the command line before the sources are read."""

import re
from argparse import SUPPRESS, Action, ArgumentParser, HelpFormatter, _SubParsersAction
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sphinx.application import Sphinx

from beltsort.cli import GROUPS, parser

FOLDER = "commands"
INDEX = """# Commands

Each command prints its result on standard output and everything else on standard error. With `--json`, the
result is exactly one JSON object. [Recovery from failures](../recovery.md) lists the exit codes.

{tables}

```{{toctree}}
:hidden:

{names}
```
"""
TABLE = """## {title}

| command | what it does |
|---|---|
{rows}"""
CODE = re.compile(r"(`[^`]*`|(?<![\w-])--[a-z][a-z-]*)")
SPECIAL = re.compile(r"([\\*_<>\[\]|#$])")
PAGE = re.compile(r"docs/(\w+\.md)")
WIDTH = 76
TITLES = {"positional arguments": "Arguments"}


@dataclass(frozen=True)
class Command:
    """A command: its group in the help, its name, one line about it, its parser, and an example."""

    group: str
    name: str
    summary: str
    parser: ArgumentParser
    example: str


def commands() -> Iterator[Command]:
    """Go through the commands, in the order of the help."""
    (choices,) = (action for action in parser()._actions if isinstance(action, _SubParsersAction))
    parsers = zip(choices.choices.items(), choices._choices_actions, strict=True)
    for group, modules in GROUPS.items():
        for module, ((name, command), choice) in zip(modules, parsers, strict=False):
            yield Command(group, name, choice.help or "", command, module.EXAMPLE)


def markdown(text: str) -> str:
    """Return a plain text as Markdown: code stays code, options become code, and names of pages links."""
    pieces = CODE.split(" ".join(text.split()))
    pieces[::2] = [PAGE.sub(r"[docs/\1](../\1)", SPECIAL.sub(r"\\\1", piece)) for piece in pieces[::2]]
    pieces[1::2] = [f"`{piece.strip('`')}`" for piece in pieces[1::2]]
    return "".join(pieces)


def page(command: Command) -> str:
    """Return the page of a command."""
    command.parser.formatter_class = _Wide
    parts = [f"# beltsort {command.name}", markdown(command.parser.description or command.summary)]
    parts.append(f"```sh\n{command.example}\n```")
    for group in command.parser._action_groups:
        actions = [action for action in group._group_actions if action.dest != "help"]
        actions = [action for action in actions if action.help != SUPPRESS]
        title = group.title or "options"
        if actions:
            parts += [f"## {TITLES.get(title, title.capitalize())}", markdown(group.description or "")]
            parts += [_definition(action, command.parser) for action in actions]
    parts.append(f"## Usage\n\n```text\n{command.parser.format_usage().strip()}\n```")
    return "\n\n".join(filter(None, parts)) + "\n"


class _Wide(HelpFormatter):
    def __init__(self, prog: str) -> None:
        super().__init__(prog, width=WIDTH)


def _definition(action: Action, command: ArgumentParser) -> str:
    formatter = command._get_formatter()
    named = formatter._format_action_invocation(action)
    return f"`{named}`\n: {markdown(formatter._expand_help(action))}"


def index(listed: list[Command]) -> str:
    """Return the page that lists all commands."""
    rows: dict[str, list[str]] = {}
    for command in listed:
        row = f"| [`beltsort {command.name}`]({command.name}.md) | {markdown(command.summary)} |"
        rows.setdefault(command.group, []).append(row)
    tables = [TABLE.format(title=group.capitalize(), rows="\n".join(lines)) for group, lines in rows.items()]
    return INDEX.format(tables="\n\n".join(tables), names="\n".join(command.name for command in listed))


def write(app: Sphinx) -> None:
    """Write the pages that have changed, and remove those of commands that are gone."""
    listed = list(commands())
    texts = {f"{command.name}.md": page(command) for command in listed} | {"index.md": index(listed)}
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.md"):
        if old.name not in texts:
            old.unlink()
    for file, text in texts.items():
        path = folder / file
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the writing."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
