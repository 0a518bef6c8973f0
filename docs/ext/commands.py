"""Pages of the commands, written from the parsers of the command line before the sources are read."""

import re
from argparse import (
    SUPPRESS,
    Action,
    ArgumentParser,
    HelpFormatter,
    RawDescriptionHelpFormatter,
    _SubParsersAction,
)
from collections.abc import Iterator
from pathlib import Path

from sphinx.application import Sphinx

from beltsort.cli import parser

FOLDER = "commands"
INDEX = """# Commands

Each command prints its result on standard output and everything else on standard error. With `--json`, the
result is exactly one JSON object. [Recovery from failures](../recovery.md) lists the exit codes.

| command | what it does |
|---|---|
{rows}

```{{toctree}}
:hidden:

{names}
```
"""
CODE = re.compile(r"(`[^`]*`|(?<![\w-])--[a-z][a-z-]*)")
SPECIAL = re.compile(r"([\\*_<>\[\]|#$])")
PAGE = re.compile(r"docs/(\w+\.md)")
WIDTH = 76
TITLES = {"positional arguments": "Arguments"}


def markdown(text: str) -> str:
    """Return a plain text as Markdown: code stays code, options become code, and names of pages links."""
    pieces = CODE.split(" ".join(text.split()))
    pieces[::2] = [PAGE.sub(r"[docs/\1](../\1)", SPECIAL.sub(r"\\\1", piece)) for piece in pieces[::2]]
    pieces[1::2] = [f"`{piece.strip('`')}`" for piece in pieces[1::2]]
    return "".join(pieces)


def page(name: str, command: ArgumentParser) -> str:
    """Return the page of a command."""
    command.formatter_class, own = _Wide, command.formatter_class
    parts = [f"# beltsort {name}", markdown(command.description or "")]
    parts.append(f"```text\n{command.format_usage().strip()}\n```")
    for group in command._action_groups:
        actions = [action for action in group._group_actions if action.dest != "help"]
        actions = [action for action in actions if action.help != SUPPRESS]
        title = group.title or "options"
        if actions:
            parts += [f"## {TITLES.get(title, title.capitalize())}", markdown(group.description or "")]
            parts += [_definition(action, command) for action in actions]
    if command.epilog:
        kept = issubclass(own, RawDescriptionHelpFormatter)
        parts.append(f"```text\n{command.epilog.strip()}\n```" if kept else markdown(command.epilog))
    return "\n\n".join(filter(None, parts)) + "\n"


class _Wide(HelpFormatter):
    def __init__(self, prog: str) -> None:
        super().__init__(prog, width=WIDTH)


def _definition(action: Action, command: ArgumentParser) -> str:
    formatter = command._get_formatter()
    named = formatter._format_action_invocation(action)
    return f"`{named}`\n: {markdown(formatter._expand_help(action))}"


def _commands() -> Iterator[tuple[str, str, ArgumentParser]]:
    (choices,) = (action for action in parser()._actions if isinstance(action, _SubParsersAction))
    helps = {choice.dest: choice.help or "" for choice in choices._choices_actions}
    for name, command in choices.choices.items():
        yield name, helps.get(name, ""), command


def write(app: Sphinx) -> None:
    """Write the pages that have changed, and remove those of commands that are gone."""
    commands = list(_commands())
    rows = "\n".join(f"| [`beltsort {name}`]({name}.md) | {markdown(text)} |" for name, text, _ in commands)
    names = "\n".join(name for name, _, _ in commands)
    texts = {f"{name}.md": page(name, command) for name, _, command in commands}
    texts["index.md"] = INDEX.format(rows=rows, names=names)
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
