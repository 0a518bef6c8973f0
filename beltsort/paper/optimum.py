"""Certified bounds of the optimal value, and the regret of other policies.

How far the offline solution gets depends on the machine's speed, and so do these rows; everything else that
is run here depends on its seed alone.
"""

import re
from collections.abc import Mapping
from typing import Any

from beltsort import Evaluation, Policy, Solution, SortingModel, evaluate, solve
from beltsort.paper.design import Design, Stream, seed_of
from beltsort.paper.instances import FOUR, OBJECTS, PAPER
from beltsort.paper.labels import label_point, outcomes_of
from beltsort.paper.outcomes import Point, Row, condition
from beltsort.paper.policies import BATCH, OPTIMUM, POLICIES, policy_at
from beltsort.paper.statistics import mean

WORD = re.compile(r"\w+")


def optimum_points(design: Design, seed: int) -> list[Point]:
    """Return a point for each penalty, with one and two positions, on the paper's tables."""
    return [
        label_point(
            design,
            seed,
            PAPER.model.with_positions(positions).replace(r_min=r_min, discount=design.discounts[0]),
            FOUR,
            policy=OPTIMUM,
            batches=design.batches,
            batches_regret=design.batches_optimum,
            seconds=design.seconds_optimum,
            seed_regret=seed_of(seed, Stream.OPTIMUM),
        )
        for positions in (1, 2)
        for r_min in design.r_min_optimum
    ]


def bound_optimum(point: Mapping[str, Any]) -> Row:
    """Solve a point offline.

    Returns
    -------
    Row
        `lower` and `upper` bound the value of the best policy; `rows` are those of acting by the solution,
        for each set of objects; `losses` are the discounted regrets of every policy, one per batch,
        measured against the upper bound.
    """
    model = SortingModel.from_json(point["model"])
    solution = solve(model, seconds=point["seconds"])
    rows = [
        {
            **condition(point),
            "objects": objects.name,
            **outcomes_of(_evaluated(point, model, solution, objects.labels(model))),
        }
        for objects in OBJECTS
    ]
    losses = {
        name: _losses(point, model, policy_at({**point, "policy": name}, model)[0], solution)
        for name in POLICIES
    }
    return {
        "parameter": None,
        "lower": solution.lower,
        "upper": solution.upper,
        "rows": rows,
        "losses": losses,
    }


def _evaluated(
    point: Mapping[str, Any], model: SortingModel, solution: Solution, true_classes: list[int] | None
) -> Evaluation:
    return evaluate(
        model,
        solution,
        batches=point["batches"],
        batch_size=BATCH,
        seed=point["seed"],
        threads=1,
        true_classes=true_classes,
    )


def _losses(point: Mapping[str, Any], model: SortingModel, policy: Policy, solution: Solution) -> list[float]:
    result = evaluate(
        model,
        policy,
        batches=point["batches_regret"],
        batch_size=BATCH,
        seed=point["seed_regret"],
        threads=1,
        reference=solution,
    )
    losses: list[float] = result.discounted_regrets.tolist()
    return losses


def losses_table(rows: list[Row]) -> list[Row]:
    """Return bounds and losses as a plain table, a row per penalty and number of positions."""
    return [
        {
            "positions": row["positions"],
            "discount": row["discount"],
            "r_min": row["r_min"],
            "lower": row["lower"],
            "upper": row["upper"],
            "batches": len(next(iter(row["losses"].values()))),
            **{
                f"{loss_of(name)}{suffix}": getattr(mean(losses), statistic)
                for name, losses in row["losses"].items()
                for suffix, statistic in (("", "value"), ("_standard_error", "standard_error"))
            },
        }
        for row in rows
    ]


def loss_of(policy: str) -> str:
    """Return the name of the column with a policy's loss.

    Examples
    --------
    >>> loss_of("DESPOT (recommended)")
    'DESPOT_recommended_loss'
    """
    return f"{'_'.join(WORD.findall(policy))}_loss"
