"""The results of a study as plain text."""

from beltsort.planning.bins import Estimate
from beltsort.planning.difference import half_interval
from beltsort.planning.throughput.study import PERCENTILE, SpeedResult, Throughput
from beltsort.util.text import text_table

HEADER = [
    "places/min",
    "policy",
    "objects/min",
    "right",
    "wrong",
    "missed",
    "least purity",
    "reward/object",
    "from the first",
    "plan",
]


def throughput_table(found: Throughput) -> str:
    """Format a row per speed and policy, and what holds the purity, with 95 % intervals."""
    table = text_table([HEADER, *(_row(result) for result in found.results)])
    half = found.times.tick / 2
    lines = [
        f"Estimates with half of their 95 % interval: {found.runs} runs of {found.objects} objects, seed "
        f"{found.seed}.",
        f"objects/min: decided ones. plan: {PERCENTILE:.0%} of plans took less (half a tick is {half:g} s).",
        "",
        f"Most objects per minute with a purity of at least {found.purity:g} in every bin:",
    ]
    for held in found.held():
        if held.result is None:
            lines.append(f"  {held.policy}: at none of these speeds")
            continue
        there = held.result.statistics
        speed = held.result.places_per_minute
        lower = "holds it too" if held.by_interval else "does not hold it"
        lines.append(
            f"  {held.policy}: {_half(there.objects_per_minute)} at {speed:.3g} places per minute; purity "
            f"{_half(there.least_purity)}, whose lower end {lower}"
        )
    return "\n".join([table, *lines])


def _row(result: SpeedResult) -> list[str]:
    found = result.statistics
    difference = result.reward_difference
    return [
        f"{result.places_per_minute:.3g}",
        result.policy,
        _half(found.objects_per_minute),
        _half(found.right),
        _half(found.wrong),
        _half(found.missed),
        _half(found.least_purity),
        _half(found.reward_per_object),
        _half(Estimate(difference.mean, difference.standard_error)),
        "" if result.plan_seconds is None else f"{result.plan_seconds:.4f} s",
    ]


def _half(estimate: Estimate | None) -> str:
    """Format an estimate with half of its interval in place of its standard error."""
    return "" if estimate is None else str(Estimate(estimate.value, half_interval(estimate.standard_error)))
