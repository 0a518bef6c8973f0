"""Every module that the code loads, by an import or by name, is installed by something that a user can name.

What is read here is the source, not the machine: a package that somebody installed by hand hides nothing.
"""

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LIST = ROOT / "scripts" / "debian-packages.txt"
LOADERS = {"import_module", "find_spec", "import_name", "importorskip"}
# Modules that their distribution does not tell of, and the one that pyproject.toml names for them.
INSTALLED_AS = {"pinocchio": "pin", "example_robot_data": "example-robot-data", "pydantic_core": "pydantic"}
# "std_msgs/Int32" of ROS 1; "std_msgs/msg/Int32" is the spelling of ROS 2, which rosbags knows by itself.
MESSAGE = re.compile(r"\b([a-z][a-z0-9_]*_msgs)/(?!msg/)[A-Z]")


def listed(kind: str) -> dict[str, str]:
    """Return the packages of a kind in the list, by what is loaded of them."""
    rows = [line.split() for line in LIST.read_text().splitlines() if line and not line.startswith("#")]
    return {loaded: package for row_kind, loaded, package in rows if row_kind == kind}


def loaded_by(source: str) -> Iterator[tuple[int, str]]:
    """Yield line and top-level module of all that a source file loads, lazily or by name included."""
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Import(names=names):
                yield from ((node.lineno, name.name) for name in names)
            case ast.ImportFrom(module=str(module), level=0):
                yield node.lineno, module
            case ast.Call(
                func=ast.Name(id=loader) | ast.Attribute(attr=loader),
                args=[ast.Constant(value=str(name)), *_],
            ):
                if loader in LOADERS:
                    yield node.lineno, name
            case ast.Constant(value=str(text)):
                yield from ((node.lineno, module) for module in MESSAGE.findall(text))


def declared() -> set[str]:
    """Return the distributions that pyproject.toml names."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    return {normal(re.split(r"[<>=\[;~! ]", requirement)[0]) for group in groups for requirement in group}


def normal(distribution: str) -> str:
    return distribution.lower().replace("_", "-")


def made_here() -> set[str]:
    """Return the message packages whose messages are made from definitions, without importing anything."""
    source = (ROOT / "beltsort" / "drivers" / "ros1" / "messages.py").read_text("utf-8")
    (definitions,) = (
        node.value
        for node in ast.parse(source).body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Dict)
    )
    assert isinstance(definitions, ast.Dict)
    return {ast.literal_eval(key).split("/")[0] for key in definitions.keys if key is not None}


def for_ros2(file: Path) -> bool:
    """Return whether a file runs with ROS 2's own Python: it, or a folder, is named so."""
    return any(part.startswith("ros2") for part in file.parts)


def of_ros2() -> set[str]:
    """Return the modules of scripts/ros2-packages.txt (std_msgs of ros-std-msgs) and ros2-interfaces."""
    lines = (ROOT / "scripts" / "ros2-packages.txt").read_text("utf-8").splitlines()
    names = [re.split(r"[\[=]", line)[0] for line in lines if line.startswith("ros-")]
    built = {folder.name for folder in (ROOT / "scripts" / "ros2-interfaces").iterdir()}
    return built | {name.removeprefix("ros-").replace("-", "_") for name in names}


def unaccounted(files: Iterator[Path]) -> list[str]:
    """Return "file:line module" of every module that neither Python, pyproject.toml nor the list provides."""
    ours = {"beltsort", "tests", "benchmarks"}
    provided = set(sys.stdlib_module_names) | ours | made_here() | listed("ros1").keys()
    distributions, named = packages_distributions(), declared()
    return [
        f"{file.relative_to(ROOT)}:{line} {module}"
        for file in files
        for line, module in loaded_by(file.read_text("utf-8"))
        if (top := module.split(".")[0]) not in provided | (of_ros2() if for_ros2(file) else set())
        and not file.with_name(f"{top}.py").exists()
        and not {normal(name) for name in [*distributions.get(top, []), INSTALLED_AS.get(top, "")]} & named
    ]


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["beltsort", "tests", "benchmarks", "examples"])
def test_every_module_that_is_loaded_is_installed_by_something(folder: str) -> None:
    assert unaccounted((ROOT / folder).rglob("*.py")) == []


def test_modules_loaded_lazily_or_by_name_are_seen() -> None:
    source = """
import one
def late():
    import two.part
    from three import name
    import_module("four").run()
    util.find_spec("five")
    subscribe("six_MSGS/Int32", "MSG: seven_MSGS/Point")
    bag("eight_MSGS/msg/Int32")
""".replace("_MSGS", "_msgs")  # this file is read, too
    seen = {module.split(".")[0] for _, module in loaded_by(source)}
    assert seen == {"one", "two", "three", "four", "five", "six_msgs", "seven_msgs"}


def test_a_module_that_nothing_installs_is_told_with_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[__name__], "LIST", tmp_path / "list")
    (tmp_path / "list").write_text("ros1 rospy python3-rospy\n")
    told = unaccounted(iter([ROOT / "beltsort" / "drivers" / "ros1" / "messages.py"]))
    assert any(line.endswith(" trajectory_msgs") for line in told)


def test_every_header_that_the_tests_compile_is_in_the_list() -> None:
    of_c_and_linux = re.compile(
        r"(errno|fcntl|math|stdint|stdio|stdlib|string|time|unistd|sys/\w+|arpa/inet)\.h"
    )
    included = {
        header
        for file in (ROOT / "tests").rglob("*.c")
        for header in re.findall(r"#include <(.*)>", file.read_text("utf-8"))
    }
    assert {header for header in included if not of_c_and_linux.fullmatch(header)} == listed("header").keys()


def test_every_program_that_the_tests_look_for_is_in_the_list() -> None:
    sources = "".join(file.read_text("utf-8") for file in sorted((ROOT / "tests").rglob("*.py")))
    assert set(re.findall(r'shutil\.which\("(\w+)"\)', sources)) == listed("program").keys()


def test_the_list_is_in_order() -> None:
    text = [line.split() for line in LIST.read_text().splitlines() if line and not line.startswith("#")]
    assert all(len(row) == 3 and row[0] in {"library", "ros1", "header", "program"} for row in text)
    assert all(package == f"python3-{loaded.replace('_', '-')}" for loaded, package in listed("ros1").items())
