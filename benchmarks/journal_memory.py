"""Memory of the commands that read a run's journal.

``python -m benchmarks.endurance --objects 2000 --folder FOLDER``, then ``python -m benchmarks.journal_memory
FOLDER``, prints the largest resident memory of each command, in a process of its own.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from beltsort.sorting.journal_files import journal_bytes
from beltsort.util.text import text_table

COMMANDS = {
    "export (no journal)": ["export", "paper", "{target}/model.pomdp"],
    "status": ["status", "{run}"],
    "show": ["show", "{run}"],
    "backup": ["backup", "{run}", "{target}/copy"],
}


def peak_of(words: list[str]) -> float:
    """Return the largest resident memory of a command, MB."""
    process = subprocess.Popen([sys.executable, "-m", "beltsort", *words], stdout=subprocess.DEVNULL)
    _pid, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"beltsort {' '.join(words)} has failed with exit code {process.returncode}")
    return usage.ru_maxrss / 1e3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("run", type=Path, help="folder of a run")
    run = parser.parse_args().run
    rows = [["command", "peak MB"]]
    with tempfile.TemporaryDirectory() as target:
        for name, words in COMMANDS.items():
            filled = [word.format(run=run, target=target) for word in words]
            rows.append([name, f"{peak_of(filled):.0f}"])
    print(f"journal {journal_bytes(run) / 1e6:.1f} MB")
    print(text_table(rows))


if __name__ == "__main__":
    main()
