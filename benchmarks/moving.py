"""Compare policies on a belt that never stops, and measure how long its planner thinks.

    python -m benchmarks.moving [--model FILE] [--ticks-per-place 3 5 8] [--trials 1 30] [--runs 40]

Every policy meets the same objects, and the n-th look at an object has the same random for each of them.
Decisions count with the reward expected under the exact belief, which has the mean of the realised one.
Printed are discounted returns and differences from the planner with most trials, with standard errors over
runs, the bounds at the start, and the median and the 99th percentile of a plan's time as a part of a tick.
"""

from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass, field
from math import sqrt
from pathlib import Path

import numpy as np

import beltsort
from beltsort import Belief, DecideAt, Move, MovingPlanner, SortingModel, Wait

Action = Move | Wait | DecideAt


@dataclass(frozen=True)
class Belt:
    """A belt whose camera looks and moves in one tick, and whose every place is in reach."""

    model: SortingModel
    ticks_per_place: int
    missed: float

    def reward(self, row: np.ndarray) -> float:
        """Return the expected reward of the best decision, given the distribution of the class."""
        return float(row.max() * self.model.r_max - (1 - row.max()) * self.model.r_min)


@dataclass
class Situation:
    """What a policy knows."""

    belief: Belief
    to_come: int
    viewpoint: int = 0
    offset: int = 0
    decided: set[int] = field(default_factory=set)

    def ticks_left(self, belt: Belt, place: int) -> int:
        """Return the ticks until the object at a place passes the exit."""
        return (place + 1) * belt.ticks_per_place - self.offset


Policy = Callable[[Situation], Action]


def threshold(belt: Belt, confidence: float) -> Policy:
    """Decide at a confidence or at the last moment; look from where most is learnt about undecided ones."""
    p_obs = belt.model.p_obs

    def information(rows: np.ndarray, viewpoint: int, undecided: list[int]) -> float:
        gain = 0.0
        for place in undecided:
            joint = rows[place][:, None] * p_obs[place, viewpoint]
            independent = joint.sum(1, keepdims=True) * joint.sum(0, keepdims=True)
            seen = joint > 0
            gain += float((joint[seen] * np.log(joint[seen] / independent[seen])).sum())
        return gain

    def act(situation: Situation) -> Action:
        rows = situation.belief.probabilities
        undecided = [place for place in range(len(rows)) if place not in situation.decided]
        for place in undecided:
            last = situation.ticks_left(belt, place) <= 1 and belt.reward(rows[place]) > -belt.missed
            if last or rows[place].max() >= confidence:
                return DecideAt(place, int(rows[place].argmax()))
        if not undecided:
            return Wait()
        viewpoints = range(len(belt.model.viewpoints))
        return Move(max(viewpoints, key=lambda viewpoint: information(rows, viewpoint, undecided)))

    return act


def planned(planner: MovingPlanner, seconds: list[float]) -> Policy:
    """Follow a planner; how long its plans take is added to `seconds`."""

    def act(situation: Situation) -> Action:
        plan = planner.plan(
            situation.belief,
            situation.viewpoint,
            decided=sorted(situation.decided),
            offset=situation.offset,
            to_come=situation.to_come,
        )
        seconds.append(plan.seconds)
        return plan.action

    return act


def simulated(belt: Belt, policy: Policy, objects: int, seed: int) -> float:
    """Return the discounted return of one run, which ends when the last object is decided or gone."""
    model, places = belt.model, len(belt.model.p_obs)
    draw = np.random.default_rng(seed)
    classes = draw.choice(len(model.classes), size=objects, p=model.arrival)
    looks = draw.random((objects, 1000))
    seen, first, worth, factor = [0] * objects, 0, 0.0, 1.0
    now = Situation(Belief(model), objects - places)
    while now.to_come > 0 or len(now.decided) < places:
        action = policy(now)
        if isinstance(action, DecideAt):
            worth += factor * belt.reward(now.belief.probabilities[action.position])
            now.decided.add(action.position)
            continue
        if isinstance(action, Move):
            worth -= factor * 1.0
            now.viewpoint = action.viewpoint
        now.offset, factor = now.offset + 1, factor * model.discount
        if now.offset == belt.ticks_per_place:
            now.offset = 0
            worth -= factor * belt.missed * (0 not in now.decided)
            now.belief.advance()
            now.decided = {place - 1 for place in now.decided if place > 0}
            if now.to_come == 0:
                now.decided.add(places - 1)
            now.to_come, first = max(now.to_come - 1, 0), first + 1
        if isinstance(action, Move):
            labels: list[int | None] = [None] * places
            for place in set(range(places)) - now.decided:
                thing = first + place
                row = np.cumsum(model.p_obs[place, now.viewpoint, classes[thing]])
                labels[place] = min(
                    int(np.searchsorted(row, looks[thing, seen[thing]] * row[-1], "right")), len(row) - 1
                )
                seen[thing] += 1
            now.belief.observe(now.viewpoint, labels)
    return worth


def report(belt: Belt, trials: list[int], optimism: float, objects: int, runs: int, tick: float) -> None:
    """Print the comparison for one speed of the belt."""
    seconds: dict[str, list[float]] = {}
    policies: dict[str, Policy] = {
        f"threshold {confidence}": threshold(belt, confidence) for confidence in (0.7, 0.8, 0.9, 0.95)
    }
    bounds = ""
    for count in trials:
        planner = MovingPlanner(
            belt.model,
            ticks_per_place=belt.ticks_per_place,
            reach=len(belt.model.p_obs),
            missed=[belt.missed] * len(belt.model.classes),
            trials=count,
            optimism=optimism,
        )
        start = planner.plan(Belief(belt.model), to_come=objects - len(belt.model.p_obs))
        bounds = f"{start.lower:.2f} to {start.upper:.2f}"
        name = f"planner {count}"
        policies[name] = planned(planner, seconds.setdefault(name, []))
    returns = {
        name: np.array([simulated(belt, policy, objects, seed) for seed in range(runs)])
        for name, policy in policies.items()
    }
    best = returns[f"planner {trials[-1]}"]
    print(f"H = {len(belt.model.p_obs)}, {belt.ticks_per_place} ticks per place, value at the start {bounds}")
    for name, found in returns.items():
        behind = best - found
        line = f"  {name:16} {found.mean():7.2f} +- {found.std(ddof=1) / sqrt(runs):.2f}"
        line += f"   behind {behind.mean():6.2f} +- {behind.std(ddof=1) / sqrt(runs):.2f}"
        if name in seconds:
            median, most = np.quantile(seconds[name], [0.5, 0.99])
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
        belt = Belt(model, ticks_per_place, given.missed)
        report(belt, given.trials, given.optimism, given.objects, given.runs, given.tick)


if __name__ == "__main__":
    main()
