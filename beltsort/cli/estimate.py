"""`beltsort estimate`: observation tables from scans whose truth is known."""

import hashlib
import json
from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, tell
from beltsort.cli.progress import tenths
from beltsort.cli.solve import check_writable

if TYPE_CHECKING:
    from beltsort.perception import NearestNeighbour
    from beltsort.tables.estimate import Estimate
    from beltsort.tables.log import LabelLog
    from beltsort.tables.recording import Recording
    from beltsort.tables.scans import LabelledScan

SIMULATED = "simulated"
OBJECTS, SEED = 100, 0
FIGURES = (".png", ".svg", ".pdf")
DESCRIPTION = """
Estimate the observation tables of a cell, or from a folder of recorded scans (`beltsort.tables.recording`
describes it). Labels are kept beside the model as they come: the same command goes on where a killed one
stopped, and one with more --objects or more recorded scans adds to them.
"""


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser("estimate", help="observation tables from scans", description=DESCRIPTION)
    parser.add_argument("cell", metavar="CELL", help=f"`{SIMULATED}`, or a folder of recorded scans")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="MODEL", help="where to write the model (JSON)"
    )
    parser.add_argument(
        "--classifier",
        type=Path,
        metavar="DB",
        help=f"a trained classifier; without one, `{SIMULATED}` trains its own and keeps it beside the model",
    )
    parser.add_argument(
        "--record", type=Path, metavar="FOLDER", help=f"record the scans of `{SIMULATED}` there, 7 MB each"
    )
    parser.add_argument(
        "--objects", type=int, metavar="N", help=f"objects per row of `{SIMULATED}` (default: {OBJECTS})"
    )
    parser.add_argument("--seed", type=int, metavar="N", help=f"of `{SIMULATED}` (default: {SEED})")
    parser.add_argument(
        "--smoothing", type=float, default=1.0, metavar="A", help="Dirichlet prior of each entry (default: 1)"
    )
    parser.add_argument(
        "--error", type=float, default=0.03, metavar="E", help="wanted standard error (default: 0.03)"
    )
    parser.add_argument(
        "--repeats", action="store_true", help="let the model know how often a second look repeats the first"
    )
    parser.add_argument("--figure", type=Path, metavar="PNG", help="draw the tables")
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: all cores)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Collect, estimate, save and print."""
    from beltsort.tables.estimate import estimate
    from beltsort.tables.figure import draw_tables

    check(arguments)
    classes, viewpoints, scans = labelled_scans(arguments)
    result = estimate(
        scans,
        classes,
        viewpoints,
        smoothing=arguments.smoothing,
        repeats=arguments.repeats,
        error=arguments.error,
        note=f"made by: {arguments.command_line}",
    )
    result.model.save(arguments.output)
    if arguments.figure is not None:
        draw_tables(result.counts, result.smoothing, classes, viewpoints, arguments.figure)
    if arguments.json:
        print_json({"model": str(arguments.output), "wanted_error": arguments.error, **result.to_dict()})
    else:
        show(result, arguments)
    return 0


def check(arguments: Namespace) -> None:
    """Refuse whatever can be refused before minutes are spent."""
    from beltsort.tables.counts import check_smoothing
    from beltsort.tables.intervals import check_error

    check_writable(arguments.output)
    check_smoothing(arguments.smoothing, classes=1)
    check_error(arguments.error)
    if arguments.figure is not None:
        check_writable(arguments.figure)
        if arguments.figure.suffix not in FIGURES:
            raise ArgumentError(f"{arguments.figure} ends in none of {', '.join(FIGURES)}; name a picture")


def labelled_scans(arguments: Namespace) -> "tuple[list[str], list[str], list[LabelledScan]]":
    """Return the names of classes and viewpoints, and all labelled scans."""
    if arguments.cell != SIMULATED:
        from beltsort.tables.recording import read_recording

        refuse_simulation(arguments)
        return from_recording(read_recording(Path(arguments.cell)), classifier(arguments), arguments)
    objects = OBJECTS if arguments.objects is None else arguments.objects
    seed = SEED if arguments.seed is None else arguments.seed
    if arguments.record is None:
        return from_simulation(classifier(arguments), arguments, objects, seed)
    from beltsort.sim.record import record_simulated

    recording = record_simulated(
        arguments.record,
        objects=objects,
        seed=seed,
        workers=arguments.workers,
        progress=tenths("recording"),
    )
    return from_recording(recording, classifier(arguments), arguments)


def refuse_simulation(arguments: Namespace) -> None:
    """Refuse what means nothing to a folder."""
    for name in ("record", "objects", "seed"):
        if getattr(arguments, name) is not None:
            raise ArgumentError(f"--{name} means nothing to a folder of recorded scans; leave it out")
    if arguments.classifier is None:
        raise ArgumentError(
            "--classifier is missing, expected a file that NearestNeighbour.save wrote: recorded scans are "
            "labelled with it"
        )


def classifier(arguments: Namespace) -> "NearestNeighbour":
    """Return the given classifier, or the simulated cell's own, trained once and kept beside the model."""
    from beltsort.perception import NearestNeighbour
    from beltsort.sim.collect import collect_training

    path = classifier_path(arguments)
    if arguments.classifier is None and not path.exists():
        database = collect_training(workers=arguments.workers, progress=tenths("training"))
        database.save(path)
        tell(f"classifier saved as {path}")
    return NearestNeighbour.load(path)


def classifier_path(arguments: Namespace) -> Path:
    """Return where the classifier is, or will be."""
    path: Path = arguments.classifier or arguments.output.with_suffix(".classifier.npz")
    return path


def from_simulation(
    database: "NearestNeighbour", arguments: Namespace, objects: int, seed: int
) -> "tuple[list[str], list[str], list[LabelledScan]]":
    """Label scans of the simulated cell."""
    from beltsort.sim import CellConfig
    from beltsort.sim.collect import collect_scans

    config = CellConfig()
    settings = {"cell": SIMULATED, "seed": str(seed), "config": fingerprint(asdict(config))}
    with log_beside(arguments, settings) as log:
        scans = collect_scans(
            database,
            config,
            objects=objects,
            seed=seed,
            workers=arguments.workers,
            progress=tenths("scans"),
            log=log,
        )
    return list(config.classes), [viewpoint.name for viewpoint in config.viewpoints], scans


def from_recording(
    recording: "Recording", database: "NearestNeighbour", arguments: Namespace
) -> "tuple[list[str], list[str], list[LabelledScan]]":
    """Label recorded scans."""
    from beltsort.tables.label import label_recording

    header = recording.header
    settings = {"cell": "recorded", "layout": fingerprint(asdict(header.layout))}
    with log_beside(arguments, settings) as log:
        scans = label_recording(
            recording, database, workers=arguments.workers, progress=tenths("scans"), log=log
        )
    return list(header.classes), list(header.viewpoints), scans


def log_beside(arguments: Namespace, settings: dict[str, str]) -> "LabelLog":
    """Open the log of labels that belongs to a model, and tell what it holds."""
    from beltsort.tables.log import LabelLog

    path = arguments.output.with_suffix(".labels")
    log = LabelLog(path, {**settings, "classifier": digest(classifier_path(arguments).read_bytes())})
    if known := len(log.labels()):
        tell(f"{known} scans are labelled already in {path}")
    return log


def fingerprint(settings: object) -> str:
    """Name plain data by what it holds."""
    return digest(json.dumps(settings, sort_keys=True).encode())


def digest(content: bytes) -> str:
    """Name bytes by what they hold."""
    return hashlib.sha256(content).hexdigest()[:16]


def show(result: "Estimate", arguments: Namespace) -> None:
    """Print the tables, how well they are known, and what speaks against the model."""
    from beltsort.tables.layout import agreement_text, independence_text, intervals_text, table_one, table_two

    model = result.model
    names = (model.classes, model.viewpoints)
    print(f"{result.scans} scans; smoothing {result.smoothing:g}")
    for true in range(len(model.classes)):
        print(f"\n{table_one(model.p_obs, *names, true)}")
    print(f"\n{table_two(model.p_obs, *names)}")
    print(f"\n{intervals_text(result.counts, result.smoothing, *names)}")
    print(f"\n{agreement_text(result.counts, model.viewpoints)}")
    print(f"\n{independence_text(result.tests, model.viewpoints)}")
    worst = result.worst
    print(
        f"\nThe largest standard error is {worst.error:.3f}: position {worst.position + 1}, "
        f"{model.viewpoints[worst.viewpoint]}, true {model.classes[worst.true]}, {worst.objects} objects."
    )
    if result.missing:
        print(f"{result.missing} more objects in each row would bring every one to {arguments.error:g}.")
    for warning in result.warnings():
        print(f"Warning: {warning}.")
    print(f"model: {arguments.output}")
