"""Completion, as bash asks for it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from .running import output

pytestmark = pytest.mark.process

ASKING = """
eval "$(beltsort completion bash)"
COMP_WORDS=($1)
case "$1" in *" ") COMP_WORDS+=("") ;; esac
COMP_LINE="$1" COMP_POINT=${#1} COMP_CWORD=$(( ${#COMP_WORDS[@]} - 1 )) COMP_TYPE=9
_python_argcomplete beltsort "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
printf '%s\n' "${COMPREPLY[@]}"
"""


@pytest.fixture
def shell(tmp_path: Path) -> dict[str, str]:
    """Return an environment with a `beltsort` that is the one under test."""
    script = tmp_path / "bin" / "beltsort"
    script.parent.mkdir()
    script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m beltsort "$@"\n')
    script.chmod(0o755)
    return {**os.environ, "PATH": f"{script.parent}:{os.environ['PATH']}"}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("beltsort ev", ["evaluate"]),
        ("beltsort explain runs --o", ["--object"]),
        ("beltsort plan pap", ["paper"]),
        ("beltsort evaluate paper --policy one", ["one-object"]),
        ("beltsort compare paper --policies despot thr", ["threshold"]),
        ("beltsort completion b", ["bash"]),
        ("beltsort evaluate mod", ["model.json"]),
    ],
)
def test_bash(shell: dict[str, str], tmp_path: Path, line: str, expected: list[str]) -> None:
    (tmp_path / "model.json").touch()
    asked = ["bash", "--norc", "-c", ASKING, "bash", line]
    done = subprocess.run(asked, env=shell, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert sorted(done.stdout.split()) == expected


def test_fish(shell: dict[str, str], tmp_path: Path) -> None:
    assert shutil.which("fish") is not None, "fish is not installed: `apt-get install fish`"
    script = "beltsort completion fish | source; complete -C 'beltsort ev'"
    done = subprocess.run(["fish", "-c", script], env=shell, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout.split()[:1] == ["evaluate"], done.stderr


@pytest.mark.parametrize("name", ["bash", "zsh", "fish"])
def test_scripts_name_the_program(name: str) -> None:
    assert "beltsort" in output("completion", name)
