"""Compare policies on a belt of constant speed, and measure how long its planner thinks.

    python -m benchmarks.moving [--model FILE] [--ticks-per-place 3 5 8] [--trials 1 30] [--runs 40]

Every policy meets the same objects, and the n-th look at an object has the same random for each of them.
Printed are discounted returns and differences from the planner with most trials, with standard errors over
runs, the bounds at the start, and the median and the 99th percentile of a plan's time as a part of a tick.
"""

from argparse import ArgumentParser
from pathlib import Path

import numpy as np

import beltsort
from beltsort import (
    MovingBelt,
    MovingPlanner,
    MovingThreshold,
    SortingModel,
)
from beltsort.planning.bins import mean_of
from beltsort.planning.policy import MovingPolicy
from beltsort.planning.timed import TimedPlanner

THRESHOLDS = (0.7, 0.8, 0.9, 0.95)


def report(
    belt: MovingBelt, trials: list[int], optimism: float, objects: int, runs: int, tick: float
) -> None:
    """Print the comparison for one speed of the belt."""
    planners = {
        f"planner {n}": TimedPlanner(MovingPlanner(belt, trials=n, optimism=optimism)) for n in trials
    }
    thresholds = {f"threshold {t}": MovingThreshold(belt, t, rule="information-per-tick") for t in THRESHOLDS}
    policies: dict[str, MovingPolicy] = {**thresholds, **planners}
    returns = {
        name: beltsort.evaluate_moving(belt, policy, objects=objects, runs=runs).discounted_returns
        for name, policy in policies.items()
    }
    best = list(planners)[-1]
    start = planners[best].planner.plan(belt.belief(objects))
    bounds = f"{start.lower:.2f} to {start.upper:.2f}"
    print(f"H = {belt.model.positions}, {belt.ticks_per_place} ticks per place, value at the start {bounds}")
    for name, found in returns.items():
        line = f"  {name:16} {mean_of(found)}   behind {mean_of(returns[best] - found)}"
        if name in planners:
            median, most = np.quantile(planners[name].seconds, [0.5, 0.99])
            line += f"   plan time / tick: {median / tick:.4f} median, {most / tick:.4f} p99"
        print(line, flush=True)


def main() -> None:
    """Read the command line and print a comparison for each speed."""
    parser = ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--model", type=Path, help="a model file; the paper's model if missing")
    parser.add_argument("--ticks-per-place", type=int, nargs="+", default=[3, 5, 8])
    parser.add_argument("--trials", type=int, nargs="+", default=[1, 30])
    parser.add_argument("--optimism", type=float, default=0.5, help="of the planner, 0 to 1")
    parser.add_argument("--objects", type=int, default=15)
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--missed", type=float, default=10.0, help="price of an object that passes undecided")
    parser.add_argument("--tick", type=float, default=1.0, help="seconds of a tick")
    given = parser.parse_args()
    model = SortingModel.load(given.model) if given.model else beltsort.models.paper()
    for ticks_per_place in given.ticks_per_place:
        belt = MovingBelt(
            model,
            ticks_per_place=ticks_per_place,
            reach=model.positions,
            missed=[given.missed] * len(model.classes),
        )
        report(belt, given.trials, given.optimism, given.objects, given.runs, given.tick)


if __name__ == "__main__":
    main()
