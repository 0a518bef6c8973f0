"""`beltsort sweep`: simulate a grid of models, planners and cells."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status, print_table
from beltsort.cli.progress import tenths, with_eta
from beltsort.util.extras import require

if TYPE_CHECKING:
    from beltsort.sweep.cluster import Cluster

DESCRIPTION = """
Simulate every point of a grid and write a Parquet file with one row for each point and seed. Finished rows
are stored: the same command resumes after an interruption. docs/sweep.md describes the sweep file.
"""
CERTIFICATES = ("tls_ca", "tls_cert", "tls_key")

EXAMPLE = "beltsort sweep sweep.toml --workers 2"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "sweep", help="simulate a grid of models, planners and cells", description=DESCRIPTION
    )
    parser.add_argument("config", type=Path, metavar="CONFIG", help="a sweep file (TOML)")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="output folder, with the stored rows and rows.parquet (default: CONFIG without its suffix)",
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: all cores)")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="run on a Dask cluster: tcp://HOST:PORT or tls://HOST:PORT"
    )
    parser.add_argument("--tls-ca", type=Path, metavar="PEM", help="the cluster's certificate authority")
    parser.add_argument("--tls-cert", type=Path, metavar="PEM", help="this client's certificate")
    parser.add_argument("--tls-key", type=Path, metavar="PEM", help="this client's key")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run, write and print."""
    require("sweep", "pyarrow", "pydantic", "scipy")
    from beltsort.sweep.run import FILE, Sweep

    scheduler = scheduler_of(arguments)
    folder = folder_of(arguments)
    sweep = Sweep.load(arguments.config)
    print_status(f"{len(sweep.points)} points; rows are stored in {folder}")
    sweep.prepare(tenths)
    rows = sweep.run(folder, workers=arguments.workers, progress=with_eta("points"), scheduler=scheduler)
    if arguments.json:
        print_json({"command_line": arguments.command_line, "file": str(folder / FILE), "rows": rows})
    else:
        show(rows)
        print(f"rows: {folder / FILE}")
    return 0


def folder_of(arguments: Namespace) -> Path:
    """Return the output folder."""
    config: Path = arguments.config
    folder: Path = arguments.output or config.with_suffix("")
    if folder == config:
        raise ArgumentError(
            f"CONFIG is {config}, expected a name with a suffix, without which it would be the output "
            "folder; give another folder with -o"
        )
    return folder


def scheduler_of(arguments: Namespace) -> "Cluster | None":
    """Return the Dask cluster, or None to run on this computer."""
    given = [name for name in CERTIFICATES if getattr(arguments, name) is not None]
    options = ", ".join(f"--{name.replace('_', '-')}" for name in CERTIFICATES)
    if arguments.scheduler is None:
        if given:
            raise ArgumentError(f"{options} apply to a cluster only, expected --scheduler; leave them out")
        return None
    if arguments.workers is not None:
        raise ArgumentError(
            f"--workers {arguments.workers} does not apply to a cluster, which has workers of its own; leave "
            "it out"
        )
    from beltsort.sweep.cluster import Certificates, Cluster

    if not given:
        return Cluster(arguments.scheduler)
    if len(given) < len(CERTIFICATES):
        missing = ", ".join(f"--{name.replace('_', '-')}" for name in CERTIFICATES if name not in given)
        raise ArgumentError(f"{missing} missing, expected all of {options} or none; give them too")
    return Cluster(arguments.scheduler, Certificates(*(getattr(arguments, name) for name in CERTIFICATES)))


def show(rows: list[dict[str, Any]]) -> None:
    """Print the parameters that vary, and the results."""
    results = list(rows[0])[list(rows[0]).index("spawn_key") + 1 :]
    varying = [name for name in rows[0] if any(row[name] != rows[0][name] for row in rows)]
    parameters = [name for name in varying if name not in (*results, "spawn_key", "inputs")]
    names = [*parameters, *(name for name in results if not name.endswith("_error"))]
    print_table([names, *([text(row[name]) for name in names] for row in rows)])


def text(value: Any) -> str:
    """Format a value for the table."""
    return "-" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
