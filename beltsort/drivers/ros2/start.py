"""Starts a node program with a Python that need not have beltsort: `python start.py MODULE FD`.

The packages around the node program are made here without their `__init__`, which need NumPy and the
extension.
"""

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).resolve().parent


def main() -> None:
    """Run the node program."""
    sys.path[:] = [entry for entry in sys.path if Path(entry).resolve() != HERE]
    for name, folder in (("beltsort", HERE.parents[1]), ("beltsort.drivers.ros2", HERE)):
        package = ModuleType(name)
        package.__path__ = [str(folder)]
        sys.modules[name] = package
    import_module(sys.argv[1]).main()


if __name__ == "__main__":
    main()
