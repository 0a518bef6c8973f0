"""`python -m benchmarks.machine`: measure planning and perception speed."""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import asdict

from beltsort import BeltsortError, SortingModel
from beltsort.cli.arguments import add_json
from beltsort.cli.output import print_json, print_status, print_table
from beltsort.models import paper
from benchmarks.machine.perception import PerceptionBench, run_bench_perception
from benchmarks.machine.planning import Bench, run_bench

DEBUG_BUILD = (
    "WARNING: THIS IS A DEBUG BUILD, FAR SLOWER THAN A RELEASE BUILD. Its numbers are not "
    "meaningful: install the package, or run `make build`."
)


def parser() -> ArgumentParser:
    """Return the parser of the command line."""
    arguments = ArgumentParser(
        "python -m benchmarks.machine",
        description="Measure the speed of plans by number of threads and their adherence to a deadline; or "
        "the stages of perception, compared with a plain Open3D pipeline on the same scans. Use an idle "
        "machine.",
    )
    arguments.add_argument(
        "what", nargs="?", choices=("planning", "perception"), default="planning", help="default: planning"
    )
    arguments.add_argument(
        "--model", metavar="MODEL", help="of planning: a model file (default: the paper's instance)"
    )
    arguments.add_argument(
        "--seconds", type=float, default=10.0, metavar="S", help="time to spend (default: 10)"
    )
    add_json(arguments)
    return arguments


def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit code."""
    arguments = parser().parse_args(argv)
    try:
        bench: Bench | PerceptionBench
        if arguments.what == "perception":
            bench = run_bench_perception(arguments.seconds)
        else:
            model = paper() if arguments.model is None else SortingModel.load(arguments.model)
            bench = run_bench(model, arguments.seconds)
    except BeltsortError as error:
        print_status(f"error: {error}")
        return 2
    if bench.build_profile == "debug":
        print_status(DEBUG_BUILD)
    if arguments.json:
        print_json(asdict(bench))
    elif isinstance(bench, Bench):
        show_planning(bench)
    else:
        show_perception(bench)
    return 0


def show_planning(bench: Bench) -> None:
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


def show_perception(bench: PerceptionBench) -> None:
    """Print the measurements in words."""
    print(f"{bench.processor}, {bench.processors} processors; {bench.build_profile} build")
    print(f"Milliseconds per scan, medians of {bench.turns} turns over {bench.scans} scans:")
    rows = [[stage.name, _ms(stage.own), _ms(stage.plain)] for stage in bench.stages]
    total = ["all but deproject", _ms(bench.own), _ms(bench.plain)]
    print_table([["stage", "beltsort", "plain Open3D"], *rows, total])
    print(f"The plain pipeline takes {bench.ratio:.1f} times as long.")
    print(
        f"A descriptor of {bench.descriptor_points} points: {_ms(bench.descriptor)} ms, in NumPy "
        f"{_ms(bench.plain_descriptor)} ms, {bench.descriptor_ratio:.1f} times as long."
    )


def _ms(seconds: float | None) -> str:
    return "-" if seconds is None else f"{1e3 * seconds:.2f}"


if __name__ == "__main__":
    sys.exit(main())
