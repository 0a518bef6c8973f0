"""`beltsort calibrate-check`: the calibration of beliefs, from simulated runs."""

from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort import ArgumentError, SortingModel, models
from beltsort.cli.arguments import Subparsers, add_json, check_writable
from beltsort.cli.output import print_json, print_table
from beltsort.cli.progress import tenths
from beltsort.util.extras import require
from beltsort.util.text import numbers_or_none

if TYPE_CHECKING:
    from beltsort.calibration.causes import Causes
    from beltsort.calibration.check import Arm
    from beltsort.calibration.promise import Promise
    from beltsort.perception import Classifier
    from beltsort.planning.difference import Difference

OBJECTS = 300
LARGEST_ERROR = 0.03
"""Expected calibration error above which the output suggests `--causes`."""
DESCRIPTION = """
Sort simulated objects of all classes from depth scans, and measure how often beliefs are true: a calibrated
belief of 0.9 is true nine times in ten. All models sort the same objects. Also printed is how many right
decisions the tables promise, that is with labels drawn from them. Without MODEL, three models of the
simulated cell are compared: tables without and with the dependence of repeated looks (`repeat`), and tables
with modes for labels with confidence levels.
"""

EXAMPLE = "beltsort calibrate-check --objects 100"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "calibrate-check", help="measure the calibration of beliefs", description=DESCRIPTION
    )
    parser.add_argument("models", nargs="*", metavar="MODEL", help="model files of the simulated cell")
    parser.add_argument(
        "--classifier", type=Path, metavar="DB", help="classifier of the scans (default: that of `demo`)"
    )
    parser.add_argument(
        "--objects",
        type=int,
        default=OBJECTS,
        metavar="N",
        help=f"objects sorted with each model (default: {OBJECTS})",
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of objects and noise (default: 0)"
    )
    parser.add_argument(
        "--causes",
        type=int,
        metavar="N",
        help="scan N objects from every viewpoint and position to find the causes of miscalibration",
    )
    parser.add_argument(
        "--figure",
        type=Path,
        default=Path("calibration.png"),
        metavar="PNG",
        help="file of the figure (default: calibration.png)",
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: all cores)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Sort, evaluate, draw and print."""
    require("cell", "open3d", "scipy", "matplotlib")
    from beltsort.calibration.causes import find_causes
    from beltsort.calibration.check import Arm
    from beltsort.calibration.figure import draw_reliability
    from beltsort.calibration.promise import promises
    from beltsort.calibration.sorted_runs import sort_many

    check_writable(arguments.figure)
    models, database = models_and_classifier(arguments)
    every = sort_many(
        list(models.values()),
        database,
        objects=arguments.objects,
        seed=arguments.seed,
        workers=arguments.workers,
        progress=tenths("runs"),
    )
    arms = {name: Arm.of(runs) for name, runs in zip(models, every, strict=True)}
    draw_reliability({name: arm.curves for name, arm in arms.items()}, arguments.figure)
    promised = promises(
        models, arms, seed=arguments.seed, workers=arguments.workers, progress=tenths("promises")
    )
    causes = None
    if arguments.causes is not None:
        causes = find_causes(
            models,
            database,
            objects=arguments.causes,
            seed=arguments.seed,
            workers=arguments.workers,
            progress=tenths("causes"),
        )
    if arguments.json:
        print_json(as_json(arguments, arms, promised, causes))
    else:
        show(arguments, arms, promised, causes)
    return 0


def models_and_classifier(arguments: Namespace) -> "tuple[dict[str, SortingModel], Classifier]":
    """Return the models by name and the classifier; the classifier is trained only if it is not given."""
    from beltsort.perception import load_trained

    given = {name: models.load(name) for name in arguments.models}
    if len(given) < len(arguments.models):
        raise ArgumentError(f"a model is named twice in {arguments.models}; name each once")
    if arguments.classifier is not None:
        if not given:
            raise ArgumentError(
                f"--classifier {arguments.classifier} needs MODEL, expected at least one model of its "
                "labels; name models or leave it out"
            )
        return given, load_trained(arguments.classifier)
    from beltsort.models import simulated
    from beltsort.sim import CellConfig
    from beltsort.sim.prepare import prepare

    prepared, config = prepare(progress=tenths), CellConfig()
    viewpoints = [viewpoint.name for viewpoint in config.viewpoints]
    own = {
        name: prepared.counts.model(config.classes, viewpoints, repeats=repeats)
        for name, repeats in (("without repeats", False), ("with repeats", True))
    }
    own["with modes"] = simulated()
    return given or own, prepared.database


def differences(arms: "dict[str, Arm]") -> "dict[str, dict[str, Difference]]":
    """Return the differences of every model from the first."""
    first, *others = arms
    return {name: arms[name].minus(arms[first]) for name in others}


def as_json(
    arguments: Namespace, arms: "dict[str, Arm]", promised: "dict[str, Promise]", causes: "Causes | None"
) -> dict[str, Any]:
    """Return the results as plain data."""
    return {
        "command_line": arguments.command_line,
        "seed": arguments.seed,
        "arms": {name: arm.to_dict() for name, arm in arms.items()},
        "differences": {
            name: {what: numbers_or_none(asdict(difference)) for what, difference in by.items()}
            for name, by in differences(arms).items()
        },
        "promises": {name: promise.to_dict() for name, promise in promised.items()},
        "causes": None if causes is None else causes.to_dict(),
        "figure": str(arguments.figure),
    }


def show(
    arguments: Namespace, arms: "dict[str, Arm]", promised: "dict[str, Promise]", causes: "Causes | None"
) -> None:
    """Print the results as tables."""
    from beltsort.calibration.layout import (
        arms_rows,
        dependences_rows,
        differences_rows,
        promises_rows,
        simulated_rows,
    )

    decisions = [arm.curves["decisions"] for arm in arms.values()]
    print(f"{decisions[0].objects} objects sorted with each model; per object, ± standard error:")
    print_table(arms_rows(arms))
    if len(arms) > 1:
        print(f"Minus {next(iter(arms))}, on the same objects (in standard errors):")
        print_table(differences_rows(differences(arms)))
    print("Right decisions of ten, with labels drawn from the tables (promised) and from depth scans:")
    print_table(promises_rows(promised))
    if causes is not None:
        print(
            f"Pairs of looks at the same object, {causes.objects} objects; models assume independence in all "
            "rows but the first:"
        )
        print_table(dependences_rows(causes))
        print(f"Simulated labels, at least {causes.objects} objects each:")
        print_table(simulated_rows(causes))
    elif (worst := max(curve.ece for curve in decisions)) > LARGEST_ERROR:
        print(
            f"The calibration error of decisions is {worst:.3f}, above {LARGEST_ERROR}; run with --causes "
            "200 to find its causes."
        )
    print(f"figure: {arguments.figure}")
