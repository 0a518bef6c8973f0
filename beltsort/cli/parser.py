"""The parsers of the command line: commands in groups, an example for each, suggestions for wrong words."""

import sys
from argparse import SUPPRESS, Action, ArgumentError, ArgumentParser, HelpFormatter, Namespace
from collections.abc import Iterable, Mapping, Sequence
from types import ModuleType
from typing import Any, NoReturn

from beltsort.util.naming import nearest_name, nearest_of

EXAMPLE = "example:"
"""How the end of a command's help begins."""


class HelpLines(HelpFormatter):
    """Wraps descriptions, and leaves the lines of examples and of the list of commands as they are."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if "\n  " in text else super()._fill_text(text, width, indent)


class Parser(ArgumentParser):
    """A parser that suggests the nearest command, choice or option for one that it does not know."""

    def __init__(self, prog: str | None = None, **settings: Any) -> None:
        super().__init__(prog, formatter_class=HelpLines, **settings)
        self._given: Sequence[str] = ()

    def parse_known_args(  # type: ignore[override]  # as argparse calls it, without its overloads
        self, args: Sequence[str] | None = None, namespace: Namespace | None = None
    ) -> tuple[Namespace, list[str]]:
        """Parse, and keep what was given for suggestions."""
        self._given = () if args is None else args
        return super().parse_known_args(args, namespace)

    def parse_args(  # type: ignore[override]  # as above
        self, args: Sequence[str] | None = None, namespace: Namespace | None = None
    ) -> Namespace:
        """Parse; the command's own parser reports what it does not know."""
        arguments, unknown = self.parse_known_args(args, namespace)
        if unknown:
            parser: ArgumentParser = getattr(arguments, "parser", self)
            parser.error(f"unrecognized arguments: {' '.join(unknown)}")
        return arguments

    def error(self, message: str) -> NoReturn:
        """Print usage, the message and the nearest option for each that does not exist, and exit."""
        known = [option for option in self._option_string_actions if option.startswith("--")]
        words = (word.partition("=")[0] for word in self._given if word.startswith("--") and word != "--")
        unknown = [word for word in words if not any(option.startswith(word) for option in known)]
        hints = [f"; did you mean {nearest_name(word, known)} for {word}?" for word in unknown]
        super().error(message + "".join(hints))

    def exit(self, status: int = 0, message: str | None = None) -> NoReturn:
        """Exit, after writing the help that is printed; a reader that has left is noticed here."""
        sys.stdout.flush()
        super().exit(status, message)

    def _check_value(self, action: Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            names = [str(choice) for choice in action.choices]
            raise ArgumentError(action, f"there is no {value!r}; {nearest_of(str(value), names)}")


def add_commands(top: Parser, groups: Mapping[str, Iterable[ModuleType]]) -> None:
    """Add the commands to the parser, and their names in groups to the end of its help."""
    subparsers = top.add_subparsers(metavar="COMMAND", required=True, help=SUPPRESS)
    lines = []
    for title, commands in groups.items():
        lines.append(f"{title}:")
        for command in commands:
            command.add_parser(subparsers)
            name, parser = next(reversed(subparsers.choices.items()))
            parser.epilog = f"{EXAMPLE}\n  {command.EXAMPLE}"
            parser.set_defaults(parser=parser)
            lines.append(f"  {name:<17} {subparsers._choices_actions[-1].help}")
        lines.append("")
    top.usage = f"{top.prog} [-h] [--version] COMMAND ..."
    lines.append(f"`{top.prog} COMMAND --help` prints the options of a command and an example.")
    top.epilog = "\n".join(lines)
