"""`beltsort reproduce`: run the paper's experiments."""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from beltsort import ArgumentError, models
from beltsort.cli.arguments import MODEL_HELP, Subparsers, add_json
from beltsort.cli.output import print_json, print_status, print_table
from beltsort.cli.progress import tenths
from beltsort.planning.named_policy import HELP
from beltsort.util.extras import require

if TYPE_CHECKING:
    from beltsort.paper import Design, Redrawn, Study

Number = TypeVar("Number", int, float)

FOLDER = "reproduction"

EXAMPLE = "beltsort reproduce --model model.json --policy one-object --policy mine:Policy --quick -o study"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser: ArgumentParser = subparsers.add_parser(
        "reproduce",
        help="run the paper's experiments; write figures, tables and a report",
        description="Run the paper's experiments, with labels drawn from tables and from depth scans, and "
        "write the figures (PNG, SVG, PDF), the numbers (CSV) and a report (HTML) to a folder. An "
        "interrupted run resumes if started again with the same folder. The full run takes about three "
        "quarters of an hour on two idle cores. --from draws figures and report again from the numbers "
        "of an earlier run. --model and --policy run those experiments that need no depth scans with a model "
        "and with policies of your own, beside the paper's policies.",
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--quick",
        action="store_true",
        help="few batches, three penalties for depth scans, no discount of 0.99, at most three positions, "
        "three belt speeds; takes under four minutes",
    )
    what.add_argument(
        "--from",
        dest="source",
        type=Path,
        metavar="FOLDER",
        help="draw figures and report from the CSV files of this folder, and run nothing",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help=f"(default: {FOLDER}, or with --from its own folder)",
    )
    own = parser.add_argument_group("a study of your own")
    own.add_argument("--model", metavar="MODEL", help=f"{MODEL_HELP} (default with --policy: paper)")
    own.add_argument("--policy", action="append", metavar="POLICY", help=f"may be repeated: {HELP}")
    own.add_argument(
        "--positions",
        metavar="H,H",
        help="numbers of belt positions seen at once, from 1 to the model's (default: 1 and all)",
    )
    own.add_argument(
        "--r-min",
        metavar="R,R",
        help="penalties of a wrong decision beside the model's own, at which claims are tested (default: the "
        "paper's, 5 to 500, scaled to the model's largest reward)",
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one for each core)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed (default: 0)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run, write and print which claims hold."""
    require("cell", "open3d", "scipy", "matplotlib")
    from beltsort.paper import FULL, QUICK, redraw, reproduce
    from beltsort.paper.files import outline_in
    from beltsort.sim.demo import check_seed
    from beltsort.sim.prepare import prepare
    from beltsort.sorting.runs import make_folder
    from beltsort.util.processes import at_least_one

    # Arguments are checked before minutes are spent on simulations.
    check_seed(arguments.seed)
    if arguments.workers is not None:
        at_least_one("workers", arguments.workers)
    design = QUICK if arguments.quick else FULL
    study = own_of(arguments, design)
    output = arguments.output or arguments.source or Path(FOLDER)
    make_folder(output)
    done: Redrawn
    if arguments.source is not None:
        papers = outline_in(arguments.source).of_the_paper
        done = redraw(prepare(progress=tenths) if papers else None, arguments.source, output)
    else:
        done = reproduce(
            prepare(progress=tenths) if study is None else None,
            output,
            design if study is None else study,
            seed=arguments.seed,
            workers=arguments.workers,
            stage=tenths,
            command=arguments.command_line,
        )
    if arguments.json:
        print_json(as_json(done, arguments))
    else:
        show_text(done)
    return 0


def own_of(arguments: Namespace, design: "Design") -> "Study | None":
    """Return the study of a model and of policies of one's own; None if none are given."""
    from beltsort.paper import own_study

    varied = (arguments.positions, arguments.r_min)
    if arguments.model is None and not arguments.policy:
        if any(each is not None for each in varied):
            raise ArgumentError("--positions and --r-min are of a study of your own; add --model or --policy")
        return None
    if arguments.source is not None:
        raise ArgumentError("--from runs nothing, and so takes no --model and no --policy; leave them out")
    name = arguments.model or "paper"
    return own_study(
        models.load(name),
        Path(name).name,
        design,
        policies=arguments.policy or (),
        positions=_numbers("--positions", arguments.positions, int),
        r_min=_numbers("--r-min", arguments.r_min, float),
    )


def _numbers(option: str, text: str | None, kind: Callable[[str], Number]) -> list[Number] | None:
    """Parse numbers separated by commas; None stays None."""
    if text is None:
        return None
    try:
        return [kind(word) for word in text.split(",")]
    except ValueError as reason:
        raise ArgumentError(
            f"{option} {text}: expected numbers separated by commas, 1,2 for example"
        ) from reason


def as_json(done: "Redrawn", arguments: Namespace) -> dict[str, Any]:
    """Return the findings and the written files as plain data."""
    from beltsort.paper import Reproduction

    ran = done if isinstance(done, Reproduction) else None
    about = done.numbers.circumstances
    return {
        "command_line": arguments.command_line,
        "seed": about.seed,
        "quick": about.quick,
        "report": str(done.report),
        "tables": [] if ran is None else [str(path) for path in ran.tables],
        "figures": [picture.name for picture in done.pictures],
        "seconds": {} if ran is None else {name: round(s, 1) for name, s in ran.results.seconds.items()},
        "findings": [result.plain() for result in done.numbers.findings],
    }


def show_text(done: "Redrawn") -> None:
    """Print which claims hold, by condition."""
    where = ""
    for result in done.numbers.findings:
        if result.where != where:
            where = result.where
            print(f"\n{where}")
        print_table([[f"{result.conclusion}:", result.claim]])
        print(f"    {result.text}")
    for sentence in done.numbers.circumstances.outline.left_out:
        print_status(sentence)
    print_status(f"written: {done.report}, {len(done.pictures)} figures")
