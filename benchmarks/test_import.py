"""Duration of `import beltsort` in a new interpreter, without its start."""

import subprocess
import sys

from pytest_benchmark.fixture import BenchmarkFixture

SCRIPT = """
import time
start = time.perf_counter()
import beltsort
print(time.perf_counter() - start)
"""
MOST_SECONDS = 0.5


def seconds() -> float:
    return float(subprocess.run([sys.executable, "-c", SCRIPT], stdout=subprocess.PIPE, check=True).stdout)


def test_import(benchmark: BenchmarkFixture) -> None:
    assert min(benchmark(seconds), seconds(), seconds()) < MOST_SECONDS
