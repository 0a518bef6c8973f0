"""The paper's tables on a belt that never stops: the study of throughput as an experiment.

The paper's belt stops for every object. No published figure of active perception on a moving belt was found,
so these results are compared with none but those of a belt that stands while the arm looks.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from beltsort import SortingModel
from beltsort.paper.design import Design, Stream, seed_of
from beltsort.paper.instances import PAPER
from beltsort.paper.outcomes import Point, Row, estimate_in
from beltsort.paper.statistics import ClaimResult, Estimate, conclude
from beltsort.planning.named_moving_policy import STOP_AND_GO
from beltsort.planning.throughput import OBJECTS, PURITY, ArmTimes, throughput

POLICIES = (
    "moving-search:1",
    "information-per-tick:0.95",
    "most-urgent:0.99",
    f"{STOP_AND_GO}:threshold:0.94",
    f"{STOP_AND_GO}:one-object",
)
OUTCOMES = ("objects_per_minute", "right", "wrong", "missed", "least_purity", "reward_per_object")
WHERE = "labels from tables (the paper's tables), a belt that never stops"
TIMES = ArmTimes()
MISSED = 0.0
SETTING = (
    "The paper's belt stops for every object. No published figure of active perception on a moving belt was "
    "found, so nothing printed stands beside these numbers, which are simulated: labels from the paper's "
    f"tables, both positions in reach, {TIMES.move:g} s for a move of the camera and {TIMES.scan:g} s for a "
    "scan, and no price of an object that passes the exit undecided but the reward that it would have "
    "earned. Stop-and-go is the same cell with a belt that stands while the arm looks and advances by one "
    "place at the speed given. Objects per minute are decided ones; purity is that of the least pure bin. "
    "Thresholds are not tuned."
)


def moving_points(design: Design, seed: int) -> list[Point]:
    """Return a point per belt speed; all policies meet the same objects at every speed."""
    return [
        {
            "model": PAPER.model.to_json(),
            "speed": speed,
            "policies": list(POLICIES),
            "seconds": vars(TIMES),
            "missed_price": MISSED,
            "objects": OBJECTS,
            "runs": design.runs_moving,
            "seed": seed_of(seed, Stream.MOVING),
        }
        for speed in design.speeds
    ]


def sort_moving(point: Mapping[str, Any]) -> Row:
    """Run a point: `results` are those of each policy at its speed, as in `beltsort throughput --json`."""
    found = throughput(
        SortingModel.from_json(point["model"]),
        point["policies"],
        [point["speed"]],
        ArmTimes(**point["seconds"]),
        missed=point["missed_price"],
        objects=point["objects"],
        runs=point["runs"],
        seed=point["seed"],
    )
    return {"results": found.to_dict()["results"]}


def moving_table(rows: Iterable[Row]) -> list[Row]:
    """Return a plain row per speed and policy; the time of plans, which depends on the machine, is left out.

    Parameters
    ----------
    rows
        Points of `moving_points` with the results of `sort_moving`.

    Returns
    -------
    list of Row
        Policy, speed, runs (`batches`) of so many `objects`, and each of `OUTCOMES` with its standard error;
        the purity is None where no object was decided.
    """
    return [
        {
            **{name: result[name] for name in ("policy", "places_per_minute", "ticks_per_place")},
            "batches": row["runs"],
            "objects": row["objects"],
            **{
                column: value
                for name in OUTCOMES
                for column, value in (
                    (name, result[name]["value"]),
                    (f"{name}_standard_error", _nan_for_none(result[name]["standard_error"])),
                )
            },
        }
        for row in rows
        for result in row["results"]
    ]


def fastest_pure(rows: Iterable[Row], *, by_interval: bool = False) -> Row | None:
    """Return the row with most objects per minute of those that hold the purity; None if none does.

    Parameters
    ----------
    rows
        Of `moving_table`.
    by_interval
        Whether the lower end of the 95 % interval of the purity has to hold it, instead of the estimate.
    """
    pure = []
    for row in rows:
        purity = estimate_in(row, "least_purity")
        if (purity.interval[0] if by_interval else purity.value) >= PURITY:
            pure.append(row)
    return max(pure, key=lambda row: float(row["objects_per_minute"]), default=None)


def held_table(rows: Iterable[Row]) -> list[Row]:
    """Return for each policy the most objects per minute at which the purity is held, as text."""
    by_policy: dict[str, list[Row]] = {}
    for row in rows:
        by_policy.setdefault(row["policy"], []).append(row)
    return [
        {
            "policy": policy,
            "held by the estimate": _in_words(fastest_pure(own)),
            "held by the lower end of its 95 % interval": _in_words(fastest_pure(own, by_interval=True)),
        }
        for policy, own in by_policy.items()
    ]


def moving_claims(rows: Sequence[Row]) -> list[ClaimResult]:
    """Compare the most objects per minute on a moving belt with those of stop-and-go, at a purity of both.

    The purity is held by the estimates, then by the lower ends of their intervals. Where one of the two does
    not hold it at any speed there is nothing to compare, and no result.
    """
    stopping = [row for row in rows if row["policy"].startswith(STOP_AND_GO)]
    moving = [row for row in rows if row not in stopping]
    found = []
    for by_interval, how in ((False, "by the estimate"), (True, "by the lower end of its interval")):
        one, other = (fastest_pure(each, by_interval=by_interval) for each in (moving, stopping))
        if one is None or other is None:
            continue
        rate, standing = (estimate_in(row, "objects_per_minute") for row in (one, other))
        error = math.hypot(rate.standard_error, standing.standard_error)
        gained = Estimate(rate.value - standing.value, error, rate.n)
        text = (
            f"With a purity of at least {PURITY:g} {how}, {one['policy']} decides {_in_words(one)} "
            f"on a moving belt, where {100 * one['missed']:.1f} % of the objects are missed, and "
            f"{other['policy']} {_in_words(other)}, where none is: a difference of "
            f"{gained.in_words(digits=2)}, its error as of independent runs. Policy and speed of both are "
            "chosen from the same runs."
        )
        claim = f"a belt that never stops sorts more per minute than stop-and-go, purity {PURITY:g} {how}"
        found.append(ClaimResult(claim, WHERE, conclude(gained, 0.0), gained, text))
    return found


def _in_words(row: Row | None) -> str:
    if row is None:
        return "at none of these speeds"
    rate, speed = row["objects_per_minute"], row["places_per_minute"]
    return f"{rate:.1f} objects a minute at {speed:.3g} places per minute"


def _nan_for_none(value: float | None) -> float:
    return math.nan if value is None else value
