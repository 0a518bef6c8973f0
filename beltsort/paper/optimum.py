"""Certified bounds of the optimal value, and the regret of other policies.

How far the offline solution gets depends on the machine's speed, and so do these rows; everything else that
is run here depends on its seed alone.
"""

import re
from collections.abc import Mapping
from typing import Any

from beltsort import Evaluation, Policy, Solution, SortingModel, evaluate, solve
from beltsort.paper.design import Stream, seed_of
from beltsort.paper.instances import Objects, with_penalty
from beltsort.paper.labels import label_point, outcomes_of
from beltsort.paper.outcomes import Point, Row, condition
from beltsort.paper.policies import BATCH, OPTIMUM, policy_at
from beltsort.paper.statistics import mean
from beltsort.paper.study import Study

WORD = re.compile(r"\w+")


def optimum_points(seed: int, study: Study) -> list[Point]:
    """Return a point for each penalty and each number of positions that can be solved."""
    design, outline = study.design, study.outline
    return [
        label_point(
            design,
            seed,
            with_penalty(study.instance.model.with_positions(positions), r_min).replace(
                discount=design.discounts[0]
            ),
            outline.objects[-1],
            study=outline.name,
            instance=study.instance.name,
            r_min=r_min,
            policy=OPTIMUM,
            batches=design.batches,
            batches_regret=design.batches_optimum,
            seconds=design.seconds_optimum,
            seed_regret=seed_of(seed, Stream.OPTIMUM),
            played=[[objects.name, list(objects.classes)] for objects in outline.objects],
            compared=list(outline.policies),
        )
        for positions in study.optimum_positions
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
            **outcomes_of(model, _evaluated(point, model, solution, objects.labels(model))),
        }
        for objects in (Objects(name, tuple(classes)) for name, classes in point["played"])
    ]
    losses = {
        name: _losses(point, model, policy_at({**point, "policy": name}, model)[0], solution)
        for name in point["compared"]
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
