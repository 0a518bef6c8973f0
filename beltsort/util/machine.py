"""Properties of the machine and of what is installed on it."""

import os
import platform
import sys
from pathlib import Path

OTHER_NAMES = {"open3d": ("open3d-cpu", "open3d")}
"""Packages of which several builds exist, each under a name of its own."""


def processors() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def processor_name(cpuinfo: Path = Path("/proc/cpuinfo")) -> str:
    """Return the processor's model if it is known, otherwise its architecture."""
    try:
        lines = cpuinfo.read_text().splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())


def installed_version(package: str) -> str | None:
    """Return the version of a package, under any of its names, or None if it is not installed."""
    from importlib.metadata import PackageNotFoundError, version  # takes a while

    for name in OTHER_NAMES.get(package, (package,)):
        try:
            return version(name)
        except PackageNotFoundError:
            continue
    return None


def peak_memory() -> int:
    """Return the largest resident memory of this process so far, in bytes."""
    import resource  # POSIX only; every command imports this module

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
