"""Running the real command."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

PAPER = str(Path(__file__).parent.parent / "fixtures" / "paper.json")


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "beltsort", *arguments], capture_output=True, text=True)


def output(*arguments: str) -> str:
    done = command(*arguments)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout


def json_of(*arguments: str) -> dict[str, Any]:
    result = json.loads(output(*arguments, "--json"))
    assert isinstance(result, dict)
    return result
