"""`beltsort estimate`: estimate observation tables from scans of objects with known classes."""

import hashlib
import json
from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json, check_writable
from beltsort.cli.output import print_json, print_status
from beltsort.cli.progress import tenths
from beltsort.sim.config import TABLE_OBJECTS

if TYPE_CHECKING:
    from beltsort.perception import Classifier, LabelRule
    from beltsort.planning.expectation import Expectation
    from beltsort.tables.estimate import Estimate
    from beltsort.tables.log import LabelLog
    from beltsort.tables.matches import MatchedScan, MatchLog
    from beltsort.tables.recording import Recording
    from beltsort.tables.scans import LabelledScan

SIMULATED = "simulated"
SEED = 0
FIGURES = (".png", ".svg", ".pdf")
DESCRIPTION = """
Estimate observation tables from scans of the simulated cell, or from a folder of recorded scans
(`beltsort.tables.recording` describes its format). Labels are stored beside the model as they are computed:
the same command resumes after an interruption, and more --objects or more recorded scans add to them.
"""


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "estimate", help="estimate observation tables from scans", description=DESCRIPTION
    )
    parser.add_argument("cell", metavar="CELL", help=f"`{SIMULATED}`, or a folder of recorded scans")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="MODEL", help="where to write the model (JSON)"
    )
    parser.add_argument(
        "--classifier",
        metavar="DB",
        help="a trained classifier, or MODULE:OBJECT, one of your own; if its results change, name another "
        f"output (default for `{SIMULATED}`: one is trained and saved beside the model)",
    )
    parser.add_argument(
        "--record", type=Path, metavar="FOLDER", help=f"record the scans of `{SIMULATED}` here, 7 MB each"
    )
    parser.add_argument(
        "--objects",
        type=int,
        metavar="N",
        help=f"objects per row of `{SIMULATED}` (default: {TABLE_OBJECTS})",
    )
    parser.add_argument("--seed", type=int, metavar="N", help=f"seed of `{SIMULATED}` (default: {SEED})")
    parser.add_argument(
        "--smoothing", type=float, default=1.0, metavar="A", help="Dirichlet prior of each entry (default: 1)"
    )
    parser.add_argument(
        "--error", type=float, default=0.03, metavar="E", help="target standard error (default: 0.03)"
    )
    parser.add_argument(
        "--repeats", action="store_true", help="estimate the model's key `repeat` from repeated looks"
    )
    parser.add_argument(
        "--levels",
        choices=["auto", "1", "2", "3", "4"],
        metavar="N",
        help="levels of confidence of the labels, 1 to 4, or `auto`: chosen by the log-loss of held-out "
        "objects (default: labels are the classes)",
    )
    parser.add_argument("--figure", type=Path, metavar="PNG", help="draw the tables")
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: all cores)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Collect, estimate, save and print."""
    from beltsort.planning.expectation import expectation
    from beltsort.tables.estimate import estimate
    from beltsort.tables.figure import draw_tables

    check(arguments)
    labelled = labelled_scans(arguments)
    classes, viewpoints = labelled.classes, labelled.viewpoints
    result = estimate(
        labelled.scans,
        classes,
        viewpoints,
        rule=labelled.rule,
        smoothing=arguments.smoothing,
        repeats=arguments.repeats,
        error=arguments.error,
        note=f"made by: {arguments.command_line}",
    )
    result.model.save(arguments.output)
    if arguments.figure is not None:
        labels = result.model.labels
        draw_tables(result.counts, result.smoothing, classes, viewpoints, arguments.figure, labels)
    expected = expectation(result.model)
    if arguments.json:
        settings = {"model": str(arguments.output), "wanted_error": arguments.error}
        print_json({**settings, **result.to_dict(), "expected": expected.to_dict()})
    else:
        show(result, expected, arguments)
    return 0


def check(arguments: Namespace) -> None:
    """Check the arguments before minutes are spent on scans."""
    from beltsort.tables.counts import check_smoothing
    from beltsort.tables.intervals import check_error

    check_writable(arguments.output)
    check_smoothing(arguments.smoothing, labels=1)
    check_error(arguments.error)
    if arguments.figure is not None:
        check_writable(arguments.figure)
        if arguments.figure.suffix not in FIGURES:
            raise ArgumentError(
                f"--figure is {arguments.figure}, expected a name that ends in one of {', '.join(FIGURES)}; "
                "rename it"
            )


class Labelled(NamedTuple):
    """Labelled scans, the names of classes and viewpoints, and the rule that made the labels, if any."""

    classes: list[str]
    viewpoints: list[str]
    scans: "list[LabelledScan]"
    rule: "LabelRule | None"


def labelled_scans(arguments: Namespace) -> Labelled:
    """Label the scans of the cell."""
    if arguments.cell != SIMULATED:
        from beltsort.tables.recording import read_recording

        check_recorded(arguments)
        return from_recording(read_recording(Path(arguments.cell)), classifier(arguments), arguments)
    objects = TABLE_OBJECTS if arguments.objects is None else arguments.objects
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


def check_recorded(arguments: Namespace) -> None:
    """Reject options that do not apply to a folder of recorded scans, and require a classifier."""
    for name in ("record", "objects", "seed"):
        if (given := getattr(arguments, name)) is not None:
            raise ArgumentError(
                f"--{name} {given} does not apply to {arguments.cell!r}, a folder of recorded scans; leave "
                "it out"
            )
    if arguments.classifier is None:
        raise ArgumentError(
            "--classifier is missing, expected a file that NearestNeighbour.save wrote, with which to label "
            "the recorded scans; `beltsort train` writes one"
        )


def classifier(arguments: Namespace) -> "Classifier":
    """Return the given classifier, or one for the simulated cell that is trained once and saved."""
    from beltsort.perception import load_classifier
    from beltsort.sim.collect import collect_training

    name = classifier_name(arguments)
    if arguments.classifier is None and not Path(name).exists():
        database = collect_training(workers=arguments.workers, progress=tenths("training"))
        database.save(name)
        print_status(f"classifier: {name}")
    return load_classifier(name)


def classifier_name(arguments: Namespace) -> str:
    """Return the name of the classifier, of which a file need not exist yet."""
    return arguments.classifier or str(arguments.output.with_suffix(".classifier.npz"))


def from_simulation(database: "Classifier", arguments: Namespace, objects: int, seed: int) -> Labelled:
    """Label scans of the simulated cell."""
    from beltsort.sim import CellConfig
    from beltsort.sim.collect import collect_matches, collect_scans

    config = CellConfig()
    settings = {"cell": SIMULATED, "seed": str(seed), "config": fingerprint(asdict(config))}
    given = {"objects": objects, "seed": seed, "workers": arguments.workers, "progress": tenths("scans")}
    viewpoints = [viewpoint.name for viewpoint in config.viewpoints]
    if arguments.levels is None:
        with log_beside(arguments, settings) as log:
            scans = collect_scans(database, config, log=log, **given)
        return Labelled(list(config.classes), viewpoints, scans, None)
    with match_log_beside(arguments, settings) as matches:
        matched = collect_matches(database, config, log=matches, **given)
    return Labelled(list(config.classes), viewpoints, *with_levels(database, matched, viewpoints, arguments))


def from_recording(recording: "Recording", database: "Classifier", arguments: Namespace) -> Labelled:
    """Label recorded scans."""
    from beltsort.tables.label import label_recording, match_recording

    header = recording.header
    settings = {"cell": "recorded", "layout": fingerprint(asdict(header.layout))}
    given = {"workers": arguments.workers, "progress": tenths("scans")}
    classes, viewpoints = list(header.classes), list(header.viewpoints)
    if arguments.levels is None:
        with log_beside(arguments, settings) as log:
            scans = label_recording(recording, database, log=log, **given)
        return Labelled(classes, viewpoints, scans, None)
    with match_log_beside(arguments, settings) as matches:
        matched = match_recording(recording, database, log=matches, **given)
    return Labelled(classes, viewpoints, *with_levels(database, matched, viewpoints, arguments))


def with_levels(
    database: "Classifier", scans: "list[MatchedScan]", viewpoints: list[str], arguments: Namespace
) -> "tuple[list[LabelledScan], LabelRule]":
    """Label scans with a rule of so many levels, print how it was chosen, and return both."""
    from beltsort.tables.confidence import fit_levels

    levels = None if arguments.levels == "auto" else int(arguments.levels)
    choice = fit_levels(database, scans, len(viewpoints), levels=levels, smoothing=arguments.smoothing)
    losses = ", ".join(f"{loss:.3f}" for loss in choice.log_losses)
    print_status(f"levels of confidence: {choice.rule.levels} (held-out log-loss {losses})")
    return [scan.labelled(choice.rule) for scan in scans], choice.rule


def log_beside(arguments: Namespace, settings: dict[str, str]) -> "LabelLog":
    """Open the log of labels beside the model, and print the number of labels in it."""
    from beltsort.tables.log import LabelLog

    path = arguments.output.with_suffix(".labels")
    log = LabelLog(path, settings | classifier_settings(arguments))
    if known := len(log.labels()):
        print_status(f"{known} scans are already labelled in {path}")
    return log


def match_log_beside(arguments: Namespace, settings: dict[str, str]) -> "MatchLog":
    """Open the log of matches beside the model, and print the number of scans in it."""
    from beltsort.tables.matches import MatchLog

    path = arguments.output.with_suffix(".matches")
    log = MatchLog(path, settings | classifier_settings(arguments))
    if known := len(log.values()):
        print_status(f"{known} scans are already classified in {path}")
    return log


def classifier_settings(arguments: Namespace) -> dict[str, str]:
    """Return what a log is known to belong to: a database's content, or the name of another classifier."""
    name = classifier_name(arguments)
    return {"classifier": digest(Path(name).read_bytes() if Path(name).exists() else name.encode())}


def fingerprint(settings: object) -> str:
    """Return a hash of plain data."""
    return digest(json.dumps(settings, sort_keys=True).encode())


def digest(content: bytes) -> str:
    """Return a hash of bytes: 16 hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()[:16]


def show(result: "Estimate", expected: "Expectation", arguments: Namespace) -> None:
    """Print the tables, their standard errors, tests of the model's assumptions, and what it promises."""
    from beltsort.tables.layout import agreement_text, independence_text, intervals_text, table_one, table_two

    model = result.model
    names = (model.classes, model.viewpoints)
    print(f"{result.scans} scans; smoothing {result.smoothing:g}")
    for true in range(len(model.classes)):
        print(f"\n{table_one(model.p_obs, *names, true, model.labels)}")
    print(f"\n{table_two(model.p_obs, *names, labels=model.labels)}")
    print(f"\n{intervals_text(result.counts, result.smoothing, *names, model.labels)}")
    print(f"\n{agreement_text(result.counts, model.viewpoints)}")
    print(f"\n{independence_text(result.tests, model.viewpoints)}")
    worst = result.worst
    print(
        f"\nThe largest standard error is {worst.error:.3f}: position {worst.position + 1}, "
        f"{model.viewpoints[worst.viewpoint]}, true {model.classes[worst.true]}, {worst.objects} objects."
    )
    if result.missing:
        print(f"{result.missing} more objects in each row would reduce every error to {arguments.error:g}.")
    for warning in result.warnings():
        print(f"Warning: {warning}.")
    print(f"\n{expected}")
    print(f"model: {arguments.output}")
