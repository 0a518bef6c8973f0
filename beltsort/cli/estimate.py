"""`beltsort estimate`: estimate observation tables from scans of objects with known classes."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json, check_writable
from beltsort.cli.labelling import SEED, Labelled, labelled_scans, several_modes
from beltsort.cli.output import print_json, print_status
from beltsort.cli.table_source import SIMULATED
from beltsort.sim.config import TABLE_OBJECTS
from beltsort.util.defaults import TARGET_ERROR
from beltsort.util.extras import require
from beltsort.util.text import position_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from beltsort.planning.expectation import Expectation
    from beltsort.tables.estimate import Estimate
    from beltsort.tables.findings import FindingCounts
    from beltsort.tables.mode_choice import ModeChoice

MOST_MODES = 8
FIGURES = (".png", ".svg", ".pdf")
DESCRIPTION = """
Estimate observation tables from scans of a simulated cell, or from a folder of recorded scans
(`beltsort.tables.recording` describes its format). With --meshes, the classes are the meshes of a folder, as
for `beltsort train`. Labels are stored beside the model as they are computed: the same command resumes after
an interruption, and more --objects or more recorded scans add to them. The exit code is 2 if no object gets a
label, for example because the poses are wrong.
"""

EXAMPLE = "beltsort estimate simulated -o model.json --objects 200"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "estimate", help="estimate observation tables from scans", description=DESCRIPTION
    )
    parser.add_argument(
        "cell",
        metavar="CELL",
        help=f"`{SIMULATED}`, the cell file of a simulated cell (.toml), a folder of recorded scans, or with "
        "--meshes a folder of meshes",
    )
    parser.add_argument(
        "--meshes",
        action="store_true",
        help="CELL contains meshes (PLY, STL, OBJ, OFF, glTF; metres, axis along z), which are scanned in "
        "the simulated cell; the class is the sub-folder's name, or that of a mesh outside of one",
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="MODEL", help="where to write the model (JSON)"
    )
    parser.add_argument(
        "--classifier",
        metavar="DB",
        help="a trained classifier, or MODULE:OBJECT, one of your own; if its results change, name another "
        "output (default for a simulated cell: its cell file's, otherwise one is trained and saved beside "
        "the model)",
    )
    parser.add_argument(
        "--record", type=Path, metavar="FOLDER", help="record the scans of a simulated cell here, 7 MB each"
    )
    parser.add_argument(
        "--objects",
        type=int,
        metavar="N",
        help=f"objects per row, of a simulated cell (default: {TABLE_OBJECTS}; with --modes rounded up to "
        "whole passages of objects past the camera)",
    )
    parser.add_argument("--seed", type=int, metavar="N", help=f"seed of a simulated cell (default: {SEED})")
    parser.add_argument(
        "--smoothing",
        type=float,
        metavar="A",
        help="Dirichlet prior of each entry, such as 1; the larger, the less is learnt from few objects "
        "(default: each row's prior is the share of right labels in all rows, with a weight that the counts "
        "themselves suggest)",
    )
    parser.add_argument(
        "--error",
        type=float,
        default=TARGET_ERROR,
        metavar="E",
        help="target standard error (default: %(default)s)",
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
    parser.add_argument(
        "--modes",
        choices=["auto", *map(str, range(1, MOST_MODES + 1))],
        metavar="N",
        help=f"modes of each class, 1 to {MOST_MODES}, by which looks at one object depend on each other, or "
        "`auto`: chosen by the log-loss of held-out objects; needs three looks or more at each object, which "
        "a simulated cell then takes (default: 1)",
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
    choice = modes_of(labelled, arguments)
    result = estimate(
        labelled.scans,
        classes,
        viewpoints,
        rule=labelled.rule,
        smoothing=arguments.smoothing,
        repeats=arguments.repeats,
        error=arguments.error,
        modes=None if choice is None else choice.tables,
        note=f"made by: {arguments.command_line}",
    )
    result.model.save(arguments.output)
    if arguments.figure is not None:
        labels = result.model.labels
        draw_tables(result.counts, result.smoothing, classes, viewpoints, arguments.figure, labels)
    expected = expectation(result.model)
    if arguments.json:
        settings = {
            "model": str(arguments.output),
            "wanted_error": arguments.error,
            "modes": None if choice is None else choice.to_dict(),
            "findings": labelled.found.to_dict(),
        }
        print_json({**settings, **result.to_dict(), "expected": expected.to_dict()})
    else:
        show(result, labelled.found, expected, arguments)
    return 0


def check(arguments: Namespace) -> None:
    """Check the arguments before minutes are spent on scans."""
    from beltsort.tables.counts import check_smoothing
    from beltsort.tables.intervals import check_error

    check_writable(arguments.output)
    if arguments.smoothing is not None:
        check_smoothing(arguments.smoothing, labels=1)
    check_error(arguments.error)
    if several_modes(arguments) and arguments.repeats:
        raise ArgumentError(
            f"--modes {arguments.modes} and --repeats are both given; modes carry how looks depend on each "
            "other: leave --repeats out"
        )
    if arguments.figure is not None:
        require("plot", "matplotlib")
        check_writable(arguments.figure)
        if arguments.figure.suffix not in FIGURES:
            raise ArgumentError(
                f"--figure is {arguments.figure}, expected a name that ends in one of {', '.join(FIGURES)}; "
                "rename it"
            )


def modes_of(labelled: Labelled, arguments: Namespace) -> "ModeChoice | None":
    """Fit tables of modes, print what was chosen and why, and return that; None if one mode is given."""
    if not several_modes(arguments):
        return None
    from beltsort.tables.mode_choice import choose_modes, fixed_modes
    from beltsort.tables.modes import ModeSettings
    from beltsort.tables.repeated_looks import RepeatedLooks, TableShape, looks_at_objects

    labels = len(labelled.classes if labelled.rule is None else labelled.rule.labels)
    positions = len(labelled.scans[0].true) if labelled.scans else 1
    shape = TableShape(positions, len(labelled.viewpoints), len(labelled.classes), labels)
    looks = RepeatedLooks.of(looks_at_objects(labelled.scans, labelled.named_modes), shape)
    settings = ModeSettings(smoothing=prior_of(labelled, arguments))
    if arguments.modes == "auto":
        choice = choose_modes(looks, settings=settings)
    else:
        choice = fixed_modes(looks, int(arguments.modes), settings)
    print_status(str(choice))
    for gain in choice.gains:
        print_status(str(gain))
    return choice


def prior_of(labelled: Labelled, arguments: Namespace) -> "float | NDArray[np.float64]":
    """Return the pseudo-counts of the tables: as given, or what all rows have in common."""
    if arguments.smoothing is not None:
        return float(arguments.smoothing)
    from beltsort.tables.counts import count
    from beltsort.tables.pooling import pooled_prior
    from beltsort.tables.scans import looks

    positions = len(labelled.scans[0].true) if labelled.scans else 1
    shape = positions, len(labelled.viewpoints), len(labelled.classes)
    label_classes = None if labelled.rule is None else labelled.rule.label_classes
    return pooled_prior(count(looks(labelled.scans), *shape, label_classes))


def show(result: "Estimate", found: "FindingCounts", expected: "Expectation", arguments: Namespace) -> None:
    """Print findings, tables, their errors, tests of the assumptions, and what the model promises."""
    from beltsort.tables.layout import agreement_text, independence_text, intervals_text, table_one, table_two

    model = result.model
    names = (model.classes, model.viewpoints)
    by_class = result.counts.probabilities(result.smoothing)
    print(f"{result.scans} scans; {smoothing_text(result.smoothing)}")
    print(f"\nwhat looks at objects found:\n{found}")
    for true in range(len(model.classes)):
        print(f"\n{table_one(by_class, *names, true, model.labels)}")
    print(f"\n{table_two(by_class, *names, labels=model.labels)}")
    print(f"\n{intervals_text(result.counts, result.smoothing, *names, model.labels)}")
    print(f"\n{agreement_text(result.counts, model.viewpoints)}")
    print(f"\n{independence_text(result.tests, model.viewpoints)}")
    worst = result.worst
    print(
        f"\nThe largest standard error is {worst.error:.3f}: position {position_number(worst.position)}, "
        f"{model.viewpoints[worst.viewpoint]}, true {model.classes[worst.true]}, {worst.objects} objects."
    )
    if result.missing:
        print(f"{result.missing} more objects in each row would reduce every error to {arguments.error:g}.")
    for warning in result.warnings():
        print(f"Warning: {warning}.")
    print(f"\n{expected}")
    print(f"model: {arguments.output}")


def smoothing_text(smoothing: "float | NDArray[np.float64]") -> str:
    """Return the prior in words."""
    if isinstance(smoothing, float):
        return f"smoothing {smoothing:g}"
    weight = smoothing[0, 0, 0].sum()
    return f"each row is shrunk towards the share of right labels in all rows, by {weight:.1f} looks"
