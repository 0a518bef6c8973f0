"""`beltsort info`: versions of the installation."""

import platform
from argparse import Namespace
from typing import Any

from beltsort import __version__
from beltsort._core import BUILD_PROFILE
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_table
from beltsort.util.machine import installed_version, processors

PACKAGES = ("numpy", "open3d", "matplotlib", "platformdirs", "pydantic", "rich")

EXAMPLE = "beltsort info"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser("info", help="print versions, build profile and number of threads")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Collect and print."""
    facts = gather()
    if arguments.json:
        print_json(facts)
        return 0
    packages = facts.pop("packages")
    if facts["build_profile"] == "debug":
        facts["build_profile"] += " (from `make dev`, plans a few times slower; run `make build` for release)"
    rows = facts | {name: found or "not installed" for name, found in packages.items()}
    print_table([(name.replace("_", " "), str(value)) for name, value in rows.items()])
    return 0


def gather() -> dict[str, Any]:
    """Return the versions, without importing the packages."""
    return {
        "beltsort": __version__,
        "build_profile": BUILD_PROFILE,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "threads": processors(),
        "packages": {name: installed_version(name) for name in PACKAGES},
    }
