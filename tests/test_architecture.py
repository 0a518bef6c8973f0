"""ARCHITECTURE.md draws the rooms of the package as they are, and arrows between them run one way."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "ARCHITECTURE.md").read_text("utf-8")
FACE = "beltsort"
"""The package's own `__init__`, a room like the others."""


def module_of(file: Path) -> str:
    parts = file.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(file): file for file in (ROOT / "beltsort").rglob("*.py")} | {"beltsort._core": None}


def room_of(module: str) -> str:
    return f"{module}.".split(".")[1] or FACE


def named(tree: ast.AST) -> Iterator[str]:
    """Yield what a file imports, also where types are checked only, and inside of functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def imported(file: Path) -> set[str]:
    """Return the modules of beltsort that a file imports."""
    found = set()
    for name in named(ast.parse(file.read_text("utf-8"))):
        while name and name not in MODULES:
            name = name.rpartition(".")[0]
        found |= {name} - {""}
    return found


IMPORTS = {module: imported(file) - {module} for module, file in MODULES.items() if file is not None}


def rooms() -> dict[str, set[str]]:
    """Return what each room imports."""
    arrows: dict[str, set[str]] = defaultdict(set)
    for module, others in IMPORTS.items():
        arrows[room_of(module)] |= {room_of(other) for other in others} - {room_of(module)}
    return arrows


def drawn() -> dict[str, set[str]]:
    """Return the same as ARCHITECTURE.md says it, from the top down."""
    picture = re.search(r"```rooms\n(.*?)```", PAGE, re.DOTALL)
    assert picture is not None
    lines = (line.split("->") for line in picture[1].splitlines())
    return {room.strip(): set(others.split()) for room, others in lines}


def test_rooms_and_arrows_are_those_of_the_page() -> None:
    assert drawn() == rooms()


def test_arrows_run_down() -> None:
    order = [*drawn(), "_core"]
    up = [
        (room, other)
        for room, others in drawn().items()
        for other in others
        if order.index(other) <= order.index(room)
    ]
    assert up == []


def test_no_file_imports_itself_by_way_of_others() -> None:
    TopologicalSorter(IMPORTS).prepare()  # raises CycleError, with the files


def test_few_rooms() -> None:
    assert len(rooms()) <= 26


def test_every_path_of_the_page_is_there() -> None:
    paths = set(re.findall(r"`((?:beltsort|rust|tests|docs|benchmarks|examples)/[\w./]*)`", PAGE))
    assert len(paths) > 40
    assert [path for path in sorted(paths) if not (ROOT / path).exists()] == []
