"""The stubs carry the docstrings of the extension: editors show what help() prints."""

import ast
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = runpy.run_path(str(ROOT / "scripts" / "stub_docstrings.py"))
STUBS: list[Path] = SCRIPT["STUBS"]


@pytest.mark.parametrize("path", STUBS, ids=lambda path: path.stem)
def test_docstrings_are_those_of_the_extension(path: Path) -> None:
    stub = path.read_text("utf-8")
    assert SCRIPT["documented"](stub) == stub, "run scripts/stub_docstrings.py"


def test_everything_public_is_documented() -> None:
    names = set()
    for path in STUBS:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
                assert ast.get_docstring(node), f"{path.name}: {node.name}"
                names.add(node.name)
    assert {"SortingModel", "p_obs", "observe", "plan", "evaluate", "vfh", "ArgumentError"} <= names


def test_a_stub_gets_docstrings_in_place_of_old_ones() -> None:
    stub = (
        'class Move:\n    """Old,\n\n    long."""\n\n'
        "    x: int\n    @property\n    def viewpoint(self) -> int: ...\n"
    )
    written = SCRIPT["documented"](stub)
    assert "Old" not in written
    assert '    """`m_k`: move the camera to a viewpoint and scan once.\n' in written
    assert written.endswith('    def viewpoint(self) -> int:\n        """Index of the viewpoint."""\n')
    assert "    x: int\n" in written
    assert SCRIPT["documented"](written) == written
