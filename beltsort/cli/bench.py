"""`beltsort bench`: how fast this machine plans, and perceives."""

from argparse import Namespace
from dataclasses import asdict

from beltsort import SortingModel
from beltsort.bench.planning import Bench, run_bench
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_table, tell
from beltsort.models import paper

DEBUG_BUILD = (
    "WARNING: THIS IS A DEBUG BUILD, FAR SLOWER THAN A RELEASE BUILD. Its numbers mean nothing: "
    "install the package, or run `make build`."
)


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "bench",
        help="how fast this machine plans, or perceives",
        description="Time plans, by number of threads and against a deadline; or the stages of perception, "
        "beside a plain Open3D pipeline on the same simulated scans. Run it on an idle machine.",
    )
    parser.add_argument(
        "what", nargs="?", choices=("planning", "perception"), default="planning", help="default: planning"
    )
    parser.add_argument(
        "--model", metavar="MODEL", help="of planning: a model file (default: the paper's instance)"
    )
    parser.add_argument(
        "--seconds", type=float, default=10.0, metavar="S", help="time to spend (default: 10)"
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Measure and print."""
    if arguments.what == "perception":
        from beltsort.cli.bench_perception import run as run_perception  # loads Open3D, for a second

        return run_perception(arguments)
    model = paper() if arguments.model is None else SortingModel.load(arguments.model)
    bench = run_bench(model, arguments.seconds)
    if bench.build_profile == "debug":
        tell(DEBUG_BUILD)
    if arguments.json:
        print_json({"command_line": arguments.command_line, **asdict(bench)})
    else:
        show_text(bench)
    return 0


def show_text(bench: Bench) -> None:
    """Print the measurements in words."""
    print(f"{bench.processor}, {bench.processors} processors; {bench.build_profile} build")
    print(f"Plans of {bench.trials} trials with {bench.scenarios} scenarios, per second:")
    rows = [
        [
            str(t.threads),
            f"{t.plans:.1f}",
            f"{t.expansions:.3g}",
            f"{t.scenario_steps:.3g}",
            f"{t.speed_up:.2f}",
        ]
        for t in bench.throughput
    ]
    print_table([["threads", "plans", "expansions", "scenario steps", "speed-up"], *rows])
    late = bench.overshoot
    print(
        f"A deadline of {1e3 * late.deadline:g} ms is missed by {1e3 * late.p50:.3f} ms (median), "
        f"{1e3 * late.p99:.3f} ms (99 of 100) in {late.plans} plans."
    )
    print(f"Peak memory: {bench.peak_memory / 2**20:.0f} MiB")
