"""The planner and the simple policies it is held against, tuned on seeds of their own."""

from collections.abc import Callable, Mapping
from typing import Any

from beltsort import Despot, InformationGain, Policy, SortingModel, Threshold, evaluate

DESPOT, THRESHOLD, INFORMATION_GAIN, OPTIMUM = "DESPOT", "threshold", "information gain", "offline solution"
POLICIES = (DESPOT, THRESHOLD, INFORMATION_GAIN)

THRESHOLDS = (0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.92, 0.94, 0.96, 0.97, 0.98, 0.99, 0.995, 0.998)
BATCH = 10

SIMPLE: dict[str, Callable[[SortingModel, float], Policy]] = {
    THRESHOLD: Threshold,
    INFORMATION_GAIN: lambda model, threshold: InformationGain(model, threshold, model.positions),
}


def policy_at(point: Mapping[str, Any], model: SortingModel) -> tuple[Policy, float | None]:
    """Return a point's policy and the parameter that was tuned, if any.

    A simple policy gets the threshold with the highest mean discounted return, which is what DESPOT plans
    for, on the point's tuning seed.
    """
    if point["policy"] == DESPOT:
        return Despot(model, trials=point["trials"], threads=1), None
    make = SIMPLE[point["policy"]]
    scores = {threshold: _score(point, model, make(model, threshold)) for threshold in THRESHOLDS}
    best = max(scores, key=scores.__getitem__)
    return make(model, best), best


def _score(point: Mapping[str, Any], model: SortingModel, policy: Policy) -> float:
    result = evaluate(
        model,
        policy,
        batches=point["batches_tuning"],
        batch_size=BATCH,
        seed=point["seed_tuning"],
        threads=1,
        true_classes=point["true_classes"],
    )
    return float(result.discounted_returns.mean())
