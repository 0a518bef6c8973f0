"""`beltsort bench perception`: how fast this machine perceives."""

from argparse import Namespace
from dataclasses import asdict

from beltsort.bench.perception import PerceptionBench, run_bench_perception
from beltsort.cli.output import print_json, print_table


def run(arguments: Namespace) -> int:
    """Measure and print."""
    bench = run_bench_perception(arguments.seconds)
    if arguments.json:
        print_json({"command_line": arguments.command_line, **asdict(bench)})
    else:
        show_text(bench)
    return 0


def show_text(bench: PerceptionBench) -> None:
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
