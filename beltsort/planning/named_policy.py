"""Policies by name, `threshold:0.94` for example."""

import re
from collections.abc import Callable
from typing import Any

from beltsort._core import (
    DEFAULT_INFORMATION_POSITIONS,
    DEFAULT_LOOK_AHEAD_DEPTH,
    DEFAULT_SOLVE_SECONDS,
    ArgumentError,
    Despot,
    InformationGain,
    LookAhead,
    OneObject,
    Solution,
    SortingModel,
    Threshold,
    solve,
)
from beltsort.planning.policy import Policy

DEFAULT_TRIALS = 300  # one or two milliseconds per plan on the paper's model
DEFAULT_LAMBDA = 0.1  # regularisation of DESPOT as published
HELP = (
    f"despot[:TRIALS] (default {DEFAULT_TRIALS}), despot:SECONDSs (despot:0.01s), "
    f"despot-scenarios[:BUDGET[:LAMBDA]] (as published; default lambda {DEFAULT_LAMBDA}), "
    f"look-ahead[:DEPTH] (default {DEFAULT_LOOK_AHEAD_DEPTH}), threshold:T, "
    f"information-gain:T[:POSITIONS[:class|bin]] (default {DEFAULT_INFORMATION_POSITIONS}, class), "
    "one-object, "
    f"solution[:SECONDSs] (default {DEFAULT_SOLVE_SECONDS:g}s), solution:FILE (written by `beltsort solve`)"
)


def named_policy(text: str, model: SortingModel, **settings: Any) -> Policy:
    """Return the policy with a name.

    Parameters
    ----------
    text
        A kind and its parameters, separated by colons: see `HELP`.
    model
        The policy's model.
    settings
        Keyword arguments of `Despot`; the other kinds accept none.

    Raises
    ------
    ArgumentError
        If the kind is unknown or does not have these parameters.
    """
    kind, *parameters = text.split(":")
    if kind not in KINDS:
        raise ArgumentError(f"there is no policy {text!r}, expected one of {HELP}")
    try:
        return KINDS[kind](model, *parameters, **settings)
    except (TypeError, ValueError) as reason:
        raise ArgumentError(f"{text!r} is not a valid policy ({reason}), expected one of {HELP}") from reason


def _despot(model: SortingModel, budget: str = str(DEFAULT_TRIALS), **settings: Any) -> Policy:
    if budget.endswith("s"):
        return Despot(model, seconds=_seconds(budget), **settings)
    return Despot(model, trials=int(budget), **settings)


def _solution(model: SortingModel, *source: str) -> Policy:
    time_or_file = ":".join(source) or f"{DEFAULT_SOLVE_SECONDS}s"
    if re.fullmatch(r"[\d.]+s?", time_or_file):
        return solve(model, seconds=_seconds(time_or_file))
    return Solution.load(time_or_file, model)


def _seconds(text: str) -> float:
    if not text.endswith("s"):
        raise ValueError(f"{text} has no unit: write {text}s")
    return float(text.removesuffix("s"))


def _despot_as_published(
    model: SortingModel,
    budget: str = str(DEFAULT_TRIALS),
    regularization: str = str(DEFAULT_LAMBDA),
    **settings: Any,
) -> Policy:
    return _despot(model, budget, variant="scenarios", regularization=float(regularization), **settings)


def _information_gain(
    model: SortingModel,
    threshold: str,
    positions: str = str(DEFAULT_INFORMATION_POSITIONS),
    about: str = "class",
) -> Policy:
    if about == "class":
        return InformationGain(model, float(threshold), int(positions))
    if about == "bin":
        return InformationGain(model, float(threshold), int(positions), about="bin")
    raise ValueError(f"{about!r} is neither class nor bin")


KINDS: dict[str, Callable[..., Policy]] = {
    "despot": _despot,
    "despot-scenarios": _despot_as_published,
    "look-ahead": lambda model, depth=DEFAULT_LOOK_AHEAD_DEPTH: LookAhead(model, int(depth)),
    "threshold": lambda model, threshold: Threshold(model, float(threshold)),
    "information-gain": _information_gain,
    "one-object": OneObject,
    "solution": _solution,
}
