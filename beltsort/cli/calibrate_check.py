"""`beltsort calibrate-check`: whether a belief of 0.9 comes true nine times in ten."""

from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort import ArgumentError, SortingModel
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_table
from beltsort.cli.progress import tenths
from beltsort.cli.solve import check_writable
from beltsort.util.text import numbers_or_none

if TYPE_CHECKING:
    from beltsort.calibration.causes import Causes
    from beltsort.calibration.check import Arm
    from beltsort.perception import NearestNeighbour
    from beltsort.planning.comparison import Difference

OBJECTS = 300
TOO_MUCH = 0.03
DESCRIPTION = """
Sort simulated objects of all classes from depth scans, and hold every belief against the truth. Models that
are compared sort the same objects. Without MODEL: the simulated cell's own tables, once without and once with
what repeated looks are worth (`repeat`).
"""


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "calibrate-check", help="whether beliefs come true as often as they say", description=DESCRIPTION
    )
    parser.add_argument("models", nargs="*", metavar="MODEL", help="model files of the simulated cell")
    parser.add_argument(
        "--classifier", type=Path, metavar="DB", help="what labels the scans (default: the demonstration's)"
    )
    parser.add_argument(
        "--objects", type=int, default=OBJECTS, metavar="N", help=f"sorted with each model ({OBJECTS})"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of objects and noise (default: 0)")
    parser.add_argument(
        "--causes", type=int, metavar="N", help="look at N objects from everywhere to find what is amiss"
    )
    parser.add_argument(
        "--figure", type=Path, default=Path("calibration.png"), metavar="PNG", help="(calibration.png)"
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: all cores)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Sort, evaluate, draw and print."""
    from beltsort.calibration.causes import find_causes
    from beltsort.calibration.check import Arm
    from beltsort.calibration.figure import draw_reliability
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
        print_json(as_json(arguments, arms, causes))
    else:
        show(arguments, arms, causes)
    return 0


def models_and_classifier(arguments: Namespace) -> "tuple[dict[str, SortingModel], NearestNeighbour]":
    """Return the arms by name, and what labels the scans; training only what was not given."""
    from beltsort.perception import NearestNeighbour

    given = {name: SortingModel.load(name) for name in arguments.models}
    if len(given) < len(arguments.models):
        raise ArgumentError(f"a model is named twice in {arguments.models}; name each once")
    if arguments.classifier is not None:
        if not given:
            raise ArgumentError("--classifier means nothing without MODEL; name models of its labels")
        return given, NearestNeighbour.load(arguments.classifier)
    from beltsort.sim import CellConfig
    from beltsort.sim.prepare import prepare

    prepared, config = prepare(progress=tenths), CellConfig()
    viewpoints = [viewpoint.name for viewpoint in config.viewpoints]
    own = {
        f"{word} repeats": prepared.counts.model(config.classes, viewpoints, repeats=word == "with")
        for word in ("without", "with")
    }
    return given or own, prepared.database


def differences(arms: "dict[str, Arm]") -> "dict[str, dict[str, Difference]]":
    """Hold every arm against the first."""
    first, *others = arms
    return {name: arms[name].minus(arms[first]) for name in others}


def as_json(arguments: Namespace, arms: "dict[str, Arm]", causes: "Causes | None") -> dict[str, Any]:
    """Return everything as plain data."""
    return {
        "command_line": arguments.command_line,
        "seed": arguments.seed,
        "arms": {name: arm.to_dict() for name, arm in arms.items()},
        "differences": {
            name: {what: numbers_or_none(asdict(difference)) for what, difference in by.items()}
            for name, by in differences(arms).items()
        },
        "causes": None if causes is None else causes.to_dict(),
        "figure": str(arguments.figure),
    }


def show(arguments: Namespace, arms: "dict[str, Arm]", causes: "Causes | None") -> None:
    """Print the figures as tables."""
    from beltsort.calibration.layout import (
        arms_rows,
        dependences_rows,
        differences_rows,
        simulated_rows,
    )

    decisions = [arm.curves["decisions"] for arm in arms.values()]
    print(f"{decisions[0].objects} objects sorted with each model; per object, ± standard error:")
    print_table(arms_rows(arms))
    if len(arms) > 1:
        print(f"Minus {next(iter(arms))}, on the same objects (in standard errors):")
        print_table(differences_rows(differences(arms)))
    if causes is not None:
        print(
            f"Two looks at one object, {causes.objects} objects; model: independent, but for the first row:"
        )
        print_table(dependences_rows(causes))
        print(f"Imagined objects, at least {causes.objects} each:")
        print_table(simulated_rows(causes))
    elif max(curve.ece for curve in decisions) > TOO_MUCH:
        print(f"Decisions are not calibrated to {TOO_MUCH}; --causes 200 looks for what is amiss.")
    print(f"picture: {arguments.figure}")
