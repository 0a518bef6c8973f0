"""The planners, and the simple policies they are compared with, which are tuned on other seeds."""

import math
from collections.abc import Mapping
from typing import Any

from beltsort import InformationGain, Policy, SortingModel, Threshold, evaluate
from beltsort.planning.named_policy import named_policy

RECOMMENDED, PUBLISHED = "DESPOT (recommended)", "DESPOT as published"
THRESHOLD, INFORMATION_GAIN, OPTIMUM = "threshold", "information gain", "offline solution"
PLANNERS = {RECOMMENDED: "despot", PUBLISHED: "despot-scenarios"}
"""The planners, with their names in commands; the paper used the published one (Ye et al. 2017)."""

POLICIES = (*PLANNERS, THRESHOLD, INFORMATION_GAIN)

THRESHOLDS = (0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.92, 0.94, 0.96, 0.97, 0.98, 0.99, 0.995, 0.998)
BATCH = 10
NEGLIGIBLE = 0.01
"""Discount factor below which a reward is negligible."""


def policy_at(point: Mapping[str, Any], model: SortingModel) -> tuple[Policy, str | None]:
    """Return a point's policy and its tuned parameters as text, None if it has none.

    A simple policy gets the parameters with the highest mean discounted return on the point's tuning seed, of
    batches so long that their end does not matter, as the planners assume. Tuned on batches of ten, it would
    profit from the end of the batch.
    """
    name = point["policy"]
    if name in PLANNERS:
        return named_policy(f"{PLANNERS[name]}:{point['trials']}", model, threads=1), None
    candidates = CANDIDATES[name](model)
    scores = {parameter: _score(point, model, policy) for parameter, policy in candidates.items()}
    best = max(scores, key=scores.__getitem__)
    return candidates[best], best


def _thresholds(model: SortingModel) -> dict[str, Policy]:
    return {
        f"{threshold:g} from {name}": Threshold(model, threshold, viewpoint)
        for viewpoint, name in enumerate(model.viewpoints)
        for threshold in THRESHOLDS
    }


def _information_gains(model: SortingModel) -> dict[str, Policy]:
    return {
        f"{threshold:g}, positions counted: {counted}": InformationGain(model, threshold, counted)
        for counted in range(1, model.positions + 1)
        for threshold in THRESHOLDS
    }


CANDIDATES = {THRESHOLD: _thresholds, INFORMATION_GAIN: _information_gains}


def tuning_size(discount: float) -> int:
    """Return a batch size after which rewards are negligible, at two steps per object or more.

    Examples
    --------
    >>> tuning_size(0.95)
    45
    """
    return math.ceil(math.log(NEGLIGIBLE) / math.log(discount) / 2.0)


def _score(point: Mapping[str, Any], model: SortingModel, policy: Policy) -> float:
    size = tuning_size(model.discount)
    result = evaluate(
        model,
        policy,
        batches=math.ceil(point["batches_tuning"] * BATCH / size),
        batch_size=size,
        seed=point["seed_tuning"],
        threads=1,
        true_classes=point["true_classes"],
    )
    return float(result.discounted_returns.mean())
