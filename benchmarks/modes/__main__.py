"""`python -m benchmarks.modes`: collect looks of the simulated cell; compare tables with modes."""

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from beltsort.cli.arguments import add_json
from beltsort.cli.output import print_json, print_table
from beltsort.cli.progress import tenths
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_matches
from beltsort.sim.prepare import prepare
from beltsort.sim.rounds import passages_of
from beltsort.tables import MatchLog
from benchmarks.modes.measure import Matched, Row, measure


def parser() -> ArgumentParser:
    """Return the parser of the command line."""
    arguments = ArgumentParser(
        "python -m benchmarks.modes",
        description="Predict the class of objects of the simulated cell from several looks, with tables that "
        "were fitted to others. Collecting takes 0.35 s an object, predicting a minute.",
    )
    arguments.add_argument(
        "file", type=Path, metavar="LOOKS", help="file of what is seen in the scans; missing ones are added"
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
    matched = collect(arguments)
    rows = list(measure(matched, arguments.objects, most=arguments.modes))
    if arguments.json:
        print_json({"objects": arguments.objects, "rows": [asdict(row) for row in rows]})
    else:
        show(rows)
    return 0


def collect(arguments: Namespace) -> Matched:
    """Scan the objects, except those in the file."""
    config = CellConfig()
    of_each = -(-2 * arguments.objects // len(config.classes))
    with MatchLog(arguments.file, {"seed": str(arguments.seed)}) as log:
        scans = collect_matches(
            prepare().database,
            config,
            objects=of_each,
            seed=arguments.seed,
            passages=True,
            workers=arguments.workers,
            progress=tenths("looks"),
            log=log,
        )
    poses: dict[str, str] = {}
    for passage in passages_of(arguments.seed, of_each):
        poses |= passage.poses(config)
    return Matched(scans, config.classes, len(config.viewpoints), poses)


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
