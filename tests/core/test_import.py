"""`import beltsort` is quick and brings no heavy package along."""

import subprocess
import sys

SCRIPT = """
import sys, time
start = time.perf_counter()
import beltsort
print(time.perf_counter() - start)
heavy = {"open3d", "matplotlib", "rich", "sklearn", "pydantic", "pyarrow", "distributed"}
print(*sorted(heavy & set(sys.modules)))
"""


def test_import() -> None:
    outputs = [
        subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True).stdout
        for _ in range(3)
    ]
    seconds, heavy = zip(*(output.split("\n")[:2] for output in outputs), strict=True)
    assert set(heavy) == {""}
    assert min(map(float, seconds)) < 0.5
