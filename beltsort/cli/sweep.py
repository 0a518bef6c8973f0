"""`beltsort sweep`: a grid of models, planners and cells."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_table, tell
from beltsort.cli.progress import tenths, with_eta

if TYPE_CHECKING:
    from beltsort.sweep.cluster import Cluster

DESCRIPTION = """
Run every point of a grid and write a Parquet file with one row for each point and seed. Finished rows are
kept: the same command goes on where a killed one stopped. docs/sweep.md describes the file.
"""
CERTIFICATES = ("tls_ca", "tls_cert", "tls_key")


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "sweep", help="run a grid of models, planners and cells", description=DESCRIPTION
    )
    parser.add_argument("config", type=Path, metavar="CONFIG", help="a sweep file (TOML)")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="where rows are kept and rows.parquet is written (default: CONFIG without its ending)",
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: all cores)")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="run on a Dask cluster: tcp://HOST:PORT or tls://HOST:PORT"
    )
    parser.add_argument("--tls-ca", type=Path, metavar="PEM", help="the cluster's certificate authority")
    parser.add_argument("--tls-cert", type=Path, metavar="PEM", help="this client's certificate")
    parser.add_argument("--tls-key", type=Path, metavar="PEM", help="its key")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run, write and print."""
    from beltsort.sweep.run import FILE, Sweep

    scheduler = scheduler_of(arguments)
    folder = folder_of(arguments)
    sweep = Sweep.load(arguments.config)
    tell(f"{len(sweep.points)} points; rows are kept in {folder}")
    sweep.prepare(tenths)
    rows = sweep.run(folder, workers=arguments.workers, progress=with_eta("points"), scheduler=scheduler)
    if arguments.json:
        print_json({"command_line": arguments.command_line, "file": str(folder / FILE), "rows": rows})
    else:
        show(rows)
        print(f"rows: {folder / FILE}")
    return 0


def folder_of(arguments: Namespace) -> Path:
    """Return where the rows go."""
    config: Path = arguments.config
    folder: Path = arguments.output or config.with_suffix("")
    if folder == config:
        raise ArgumentError(f"{config} has no ending, so its rows need a folder of another name; give -o")
    return folder


def scheduler_of(arguments: Namespace) -> "Cluster | None":
    """Return the cluster that was asked for, if any."""
    given = [name for name in CERTIFICATES if getattr(arguments, name) is not None]
    options = ", ".join(f"--{name.replace('_', '-')}" for name in CERTIFICATES)
    if arguments.scheduler is None:
        if given:
            raise ArgumentError(f"{options} mean nothing without --scheduler; leave them out")
        return None
    if arguments.workers is not None:
        raise ArgumentError("--workers means nothing to a cluster, which has its own; leave it out")
    from beltsort.sweep.cluster import Certificates, Cluster

    if not given:
        return Cluster(arguments.scheduler)
    if len(given) < len(CERTIFICATES):
        raise ArgumentError(f"expected all of {options}; give the others too")
    return Cluster(arguments.scheduler, Certificates(*(getattr(arguments, name) for name in CERTIFICATES)))


def show(rows: list[dict[str, Any]]) -> None:
    """Print what varies, and the results."""
    results = list(rows[0])[list(rows[0]).index("spawn_key") + 1 :]
    varying = [name for name in rows[0] if any(row[name] != rows[0][name] for row in rows)]
    parameters = [name for name in varying if name not in (*results, "spawn_key", "inputs")]
    names = [*parameters, *(name for name in results if not name.endswith("_error"))]
    print_table([names, *([text(row[name]) for name in names] for row in rows)])


def text(value: Any) -> str:
    """Write a value in a few characters."""
    return "-" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
