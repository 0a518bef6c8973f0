"""Policies by name, `threshold:0.94` for example, or `module:object` for one's own.

An object of one's own has a method `act`, or it returns one when it is called with the model: a class, or a
function.
"""

import re
from collections.abc import Callable
from pathlib import Path
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
from beltsort.util.naming import nearest_name
from beltsort.util.references import is_reference, object_of

DEFAULT_TRIALS = 300  # one or two milliseconds per plan on the paper's model
TIME = re.compile(r"[\d.]+s?")  # otherwise the source of a solution is a file
DEFAULT_LAMBDA = 0.1  # regularisation of DESPOT as published
HELP = (
    f"despot[:TRIALS] (default {DEFAULT_TRIALS}), despot:SECONDSs (despot:0.01s), "
    f"despot-scenarios[:BUDGET[:LAMBDA]] (as published; default lambda {DEFAULT_LAMBDA}), "
    f"look-ahead[:DEPTH] (default {DEFAULT_LOOK_AHEAD_DEPTH}), threshold:T, "
    f"information-gain:T[:POSITIONS[:class|bin]] (default {DEFAULT_INFORMATION_POSITIONS}, class), "
    "one-object, "
    f"solution[:SECONDSs] (default {DEFAULT_SOLVE_SECONDS:g}s), solution:FILE (written by `beltsort solve`), "
    "module:object (a policy of your own, or a class or function that is called with the model)"
)


def named_policy(text: str, model: SortingModel, folder: Path | None = None, **settings: Any) -> Policy:
    """Return the policy with a name.

    Parameters
    ----------
    text
        A kind and its parameters, separated by colons: see `HELP`.
    model
        The policy's model.
    folder
        Where the paths of solutions start, and where modules are found that are not installed; default: the
        working folder.
    settings
        Keyword arguments of `Despot`; the other kinds accept none.

    Raises
    ------
    ArgumentError
        If the kind is unknown or does not have these parameters, or `module:object` is no policy.

    Examples
    --------
    >>> from beltsort import Belief, models
    >>> model = models.paper()
    >>> named_policy("threshold:0.94", model).act(Belief(model), 0)
    Move(viewpoint=2)
    """
    text = located_policy(text, folder or Path())
    kind, *parameters = text.split(":")
    if kind not in KINDS and is_reference(text):
        policy: Policy = own_policy(text, model, folder or Path())
        return policy
    if kind not in KINDS:
        near = nearest_name(kind, KINDS)
        raise ArgumentError(f"there is no policy {text!r}; did you mean {near!r}? Expected one of {HELP}")
    try:
        return KINDS[kind](model, *parameters, **settings)
    except (TypeError, ValueError) as reason:
        raise ArgumentError(f"{text!r} is not a valid policy ({reason}), expected one of {HELP}") from reason


def located_policy(text: str, folder: Path) -> str:
    """Return the name of a policy with the path of its solution's file, if any, starting at a folder.

    Examples
    --------
    >>> [located_policy(name, Path("/data")) for name in ("solution:paper.solution", "solution:60s")]
    ['solution:/data/paper.solution', 'solution:60s']
    """
    file = solution_file(text)
    return text if file is None else f"solution:{folder / file}"


def solution_file(text: str) -> str | None:
    """Return the path in the name of a policy that is a saved solution; None for others."""
    kind, _, source = text.partition(":")
    return source if kind == "solution" and source and not TIME.fullmatch(source) else None


def plans_by_the_clock(text: str) -> bool:
    """Whether the policy with a name depends on the speed of the machine.

    Examples
    --------
    >>> [plans_by_the_clock(name) for name in ("despot:0.01s", "solution", "despot:300", "mine:Policy")]
    [True, True, False, False]
    """
    kind, *parameters = text.split(":")
    timed = kind in ("despot", "despot-scenarios") and bool(parameters) and parameters[0].endswith("s")
    return timed or (kind == "solution" and solution_file(text) is None)


def own_policy(text: str, problem: object, folder: Path) -> Any:
    """Return the object `module:object`, or what it returns when it is called with the problem.

    Parameters
    ----------
    text
        The name.
    problem
        A model, or a moving belt.
    folder
        Where modules are found that are not installed.

    Raises
    ------
    ArgumentError
        If there is no such object, or it is no policy.
    """
    found: Any = object_of(text, folder, "policy", ArgumentError)
    if isinstance(found, type) or (callable(found) and not hasattr(found, "act")):
        try:
            found = found(problem)
        except Exception as reason:  # whatever the user's own code raises
            raise ArgumentError(
                f"the policy {text!r} cannot be made: {type(reason).__name__}: {reason}; expected a policy, "
                "or a class or function that returns one when it is called with the model: correct it"
            ) from reason
    if not callable(getattr(found, "act", None)):
        raise ArgumentError(
            f"the policy {text!r} is {found!r}, expected a method act(belief, viewpoint) that returns "
            "beltsort.Move or beltsort.Decide: add it"
        )
    return found


def _despot(model: SortingModel, budget: str = str(DEFAULT_TRIALS), **settings: Any) -> Policy:
    if budget.endswith("s"):
        return Despot(model, seconds=_seconds(budget), **settings)
    return Despot(model, trials=int(budget), **settings)


def _solution(model: SortingModel, *source: str) -> Policy:
    time_or_file = ":".join(source) or f"{DEFAULT_SOLVE_SECONDS}s"
    if TIME.fullmatch(time_or_file):
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
