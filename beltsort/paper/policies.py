"""The planners, simple policies tuned on other seeds, and policies of one's own by name."""

import hashlib
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from beltsort import ArgumentError, BeltsortError, InformationGain, Policy, SortingModel, Threshold, evaluate
from beltsort.planning.named_policy import KINDS, named_policy, plans_by_the_clock
from beltsort.util.references import is_reference, object_of

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
        return _planner(name, model, point["trials"]), None
    if name not in CANDIDATES:
        return own_policy(name, model), None
    candidates = CANDIDATES[name](model)
    scores = {parameter: _score(point, model, policy) for parameter, policy in candidates.items()}
    best = max(scores, key=scores.__getitem__)
    return candidates[best], best


def _planner(name: str, model: SortingModel, trials: int) -> Policy:
    return named_policy(f"{PLANNERS[name]}:{trials}", model, threads=1)


def papers_policy(name: str, model: SortingModel) -> Policy:
    """Return one of the paper's policies, with any parameters, to see whether the model allows for it."""
    if name in PLANNERS:
        return _planner(name, model, 1)
    return next(iter(CANDIDATES[name](model).values()))


def own_policy(word: str, model: SortingModel) -> Policy:
    """Return the policy with a name in commands, on one thread."""
    if word.partition(":")[0] in PLANNERS.values():
        return named_policy(word, model, threads=1)
    return named_policy(word, model)


def check_own(word: str, model: SortingModel, given: Sequence[str]) -> None:
    """Check that a policy of one's own can be simulated with a model, again and again with the same result.

    Parameters
    ----------
    word
        Its name.
    model
        The model, with one of the numbers of positions.
    given
        All names.

    Raises
    ------
    ArgumentError
        If it cannot; the message says what to give instead.
    """
    if word in (*POLICIES, OPTIMUM) or given.count(word) > 1:
        raise ArgumentError(f"the policy {word!r} is there already; name it once")
    if word.partition(":")[0] == "solution":
        raise ArgumentError(
            f"the policy {word!r} solves one model, and a study varies penalty and positions; leave it out: "
            "the offline solution is part of the study where it can be computed"
        )
    if plans_by_the_clock(word):
        raise ArgumentError(
            f"the policy {word!r} plans by the clock, so results would depend on the machine; give trials "
            "(despot:300)"
        )
    try:
        own_policy(word, model)
    except BeltsortError as reason:
        raise ArgumentError(f"with positions = {model.positions}: {reason}") from reason


def source_of(word: str) -> str | None:
    """Return a hash of the module of a policy `module:object`, so that a changed one is run again."""
    if word.partition(":")[0] in KINDS or not is_reference(word):
        return None
    object_of(word, Path(), "policy", ArgumentError)
    file = sys.modules[word.partition(":")[0]].__file__
    return None if file is None else hashlib.sha256(Path(file).read_bytes()).hexdigest()


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
