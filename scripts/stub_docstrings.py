#!/usr/bin/env python3
"""Write the docstrings of the extension into its stubs, so that editors show them.

    python scripts/stub_docstrings.py

The stubs are beltsort/_core.pyi and the files of beltsort/_stubs, one per public type. Signatures are kept
by hand; the docstrings of all public classes, methods, properties and functions are the built extension's.
"""

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path
from textwrap import indent

from beltsort import _core

PACKAGE = Path(__file__).parents[1] / "beltsort"
STUBS = sorted([PACKAGE / "_core.pyi", *(PACKAGE / "_stubs").glob("*.pyi")])

Definition = ast.ClassDef | ast.FunctionDef


def documented(stub: str) -> str:
    """Return the text of a stub with the docstrings of the extension."""
    starts = [0]  # of every line, in bytes, which is what the columns of `ast` count
    for line in stub.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    text = stub.encode()
    # From the end, so that places further up stay where they are.
    for node, doc in sorted(_definitions(ast.parse(stub)), key=lambda found: -found[0].lineno):
        first, last = node.body[0], node.body[-1]
        begin = starts[first.lineno - 1] + first.col_offset
        colon = text.rindex(b":", 0, begin)
        old = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
        end = starts[(first if old else node).lineno - 1] + first.col_offset
        if old:
            end = starts[(first.end_lineno or 0) - 1] + (first.end_col_offset or 0)
        docstring = indent(_quoted(doc), " " * (node.col_offset + 4), lambda line: line != "\n")
        if not old:
            end = colon + 1  # the members of a class follow
        elif first is not last:
            docstring += "\n" * (not text[end:].startswith(b"\n"))
        text = text[: colon + 1] + b"\n" + docstring.encode() + text[end:]
    return text.decode()


def _definitions(tree: ast.Module) -> Iterator[tuple[Definition, str]]:
    """Yield classes, functions and methods that have a docstring in the extension."""
    for node in tree.body:
        if isinstance(node, Definition):
            thing = getattr(_core, node.name)
            yield node, inspect.cleandoc(thing.__doc__)
            for member in node.body if isinstance(node, ast.ClassDef) else ():
                # Special methods have the docstrings of their slots, which say nothing of the class.
                if isinstance(member, ast.FunctionDef) and not member.name.startswith("__"):
                    yield member, inspect.cleandoc(getattr(thing, member.name).__doc__)


def _quoted(doc: str) -> str:
    prefix = "r" if "\\" in doc else ""
    end = "\n" if "\n" in doc else ""
    return f'{prefix}"""{doc}{end}"""'


def main() -> None:
    """Rewrite all stubs."""
    for path in STUBS:
        path.write_text(documented(path.read_text("utf-8")), "utf-8")


if __name__ == "__main__":
    main()
