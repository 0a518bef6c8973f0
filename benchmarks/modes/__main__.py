"""`python -m benchmarks.modes`: collect looks of the simulated cell; compare tables with modes."""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from beltsort.cli.arguments import add_json
from beltsort.cli.output import print_json, print_status, print_table
from beltsort.cli.progress import tenths
from beltsort.sim import CellConfig
from beltsort.sim.prepare import prepare
from benchmarks.modes.collect import SimulatedLooks, collect
from benchmarks.modes.measure import Row, measure


def parser() -> ArgumentParser:
    """Return the parser of the command line."""
    arguments = ArgumentParser(
        "python -m benchmarks.modes",
        description="Predict the class of objects of the simulated cell from several looks, with tables that "
        "were fitted to others. Collecting takes 0.35 s an object, predicting a minute.",
    )
    arguments.add_argument(
        "file", type=Path, metavar="LOOKS", help="a .npz file of looks, which is made if it is not there"
    )
    arguments.add_argument(
        "--objects", type=int, default=480, metavar="N", help="objects to fit, and others to predict"
    )
    arguments.add_argument("--modes", type=int, default=4, metavar="M", help="largest number of modes")
    arguments.add_argument("--seed", type=int, default=0, metavar="N", help="of the collected objects")
    arguments.add_argument("--workers", type=int, default=1, metavar="N", help="processes for collecting")
    add_json(arguments)
    return arguments


def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit code."""
    arguments = parser().parse_args(argv)
    if not arguments.file.exists():
        collect(
            prepare().database,
            CellConfig(),
            objects=2 * arguments.objects,
            seed=arguments.seed,
            workers=arguments.workers,
            progress=tenths("looks"),
        ).save(arguments.file)
        print_status(f"looks: {arguments.file}")
    rows = list(measure(SimulatedLooks.load(arguments.file), arguments.objects, most=arguments.modes))
    if arguments.json:
        print_json({"objects": arguments.objects, "rows": [asdict(row) for row in rows]})
    else:
        show(rows)
    return 0


def show(rows: Sequence[Row]) -> None:
    """Print a table for each kind of labels."""
    for labels in dict.fromkeys(row.labels for row in rows):
        own = [row for row in rows if row.labels == labels]
        print(f"\nLabels: {labels}. After {', '.join(map(str, own[0].looks))} looks:")
        header = ["tables", "kinds", "log-loss", "lower than one mode by", "calibration error", "right"]
        print_table([header, *(_cells(row) for row in own)])


def _cells(row: Row) -> list[str]:
    gains = zip(row.gain, row.gain_error, strict=True)
    return [
        row.candidate,
        str(row.kinds),
        " / ".join(f"{loss:.3f}" for loss in row.log_loss),
        " / ".join(f"{gain:.3f} +- {error:.3f}" for gain, error in gains),
        " / ".join(f"{error:.3f}" for error in row.calibration_error),
        " / ".join(f"{share:.3f}" for share in row.right),
    ]


if __name__ == "__main__":
    sys.exit(main())
