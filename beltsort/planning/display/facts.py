"""What is worth knowing of a model at a glance, and other parts that text and HTML have in common."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from beltsort._core import Despot, InformationGain, LookAhead, OneObject, Plan, SortingModel, Threshold
from beltsort.planning.bins import sorts_into_classes

Policy = Despot | InformationGain | LookAhead | OneObject | Threshold

MOST_NAMES = 8  # of a list of names that are shown


def sizes(model: SortingModel) -> str:
    """Return the sizes of a model.

    Examples
    --------
    >>> from beltsort.models import paper
    >>> sizes(paper())
    '4 classes, 3 viewpoints, 2 positions'
    """
    counts = {"class": len(model.classes), "viewpoint": len(model.viewpoints), "position": model.positions}
    return ", ".join(_counted(number, what) for what, number in counts.items())


def facts(model: SortingModel) -> dict[str, str]:
    """Return what the model consists of, by name: sets, rewards, and what goes beyond the paper's model.

    Examples
    --------
    >>> from beltsort.models import paper
    >>> facts(paper().replace(repeat=0.5))["repeat"]
    'a look repeats the last label with probability 0.5'
    """
    found = {"viewpoints": _listed(model.viewpoints), "classes": _listed(model.classes)}
    if any(len(weights) > 1 for weights in model.modes):
        modes = np.array([len(weights) for weights in model.modes], dtype=np.float64)
        found["modes"] = f"{_range(modes)} per class, {modes.sum():g} kinds"
    if model.labels != model.classes:
        found["labels"] = _listed(model.labels)
    if model.bins != model.classes:
        found["bins"] = _listed(model.bins)
    found["rewards"] = _rewards(model)
    found["discount"] = f"{model.discount:g}"
    return found | _extensions(model)


def settings_of(policy: Policy) -> dict[str, object]:
    """Return what a policy was made with, except for settings that are not given; a viewpoint by its name."""
    if isinstance(policy, OneObject):
        return {}
    given = {name: value for name, value in policy.settings.items() if value is not None}
    if given.get("variant") == "beliefs":
        del given["regularization"]  # which this variant does not have
    if isinstance(viewpoint := given.get("viewpoint"), int):
        given["viewpoint"] = policy.model.viewpoints[viewpoint]
    return given


def certified(plan: Plan) -> str:
    """Return the certified bounds of the optimal value."""
    if plan.certified_lower is None:
        return f"at most {plan.certified_upper:.2f}"
    return f"from {plan.certified_lower:.2f} to {plan.certified_upper:.2f}"


def objects_left(remaining: int) -> str:
    """Return how many objects are left."""
    return f"{_counted(remaining, 'object')} left"


def _counted(number: int, what: str) -> str:
    plural = f"{what}es" if what.endswith("s") else f"{what}s"
    return f"{number} {what if number == 1 else plural}"


def _listed(names: Sequence[str]) -> str:
    if any("," in name for name in names):
        names = [f'"{name}"' for name in names]
    if len(names) <= MOST_NAMES:
        return ", ".join(names)
    return f"{', '.join(names[: MOST_NAMES - 1])} and {len(names) - MOST_NAMES + 1} more"


def _rewards(model: SortingModel) -> str:
    if sorts_into_classes(model):
        decisions = f"{model.r_max:g} for a right decision, {-model.r_min:g} for a wrong one"
    else:
        decisions = f"{-model.r_min:g} to {model.r_max:g} for a decision, by bin and class"
    return f"{decisions}, {_range(-model.motion_cost)} for a move"


def _extensions(model: SortingModel) -> dict[str, str]:
    """Return the keys in which a model differs from the paper's."""
    found = {}
    if not np.allclose(model.arrival, 1.0 / len(model.classes)):
        shares = [f"{name} {p:.3g}" for name, p in zip(model.classes, model.arrival, strict=True)]
        found["arrival"] = _listed(shares)
    if any(len(reached) < len(model.viewpoints) for reached in model.travel):
        reached = np.array([len(reached) for reached in model.travel], dtype=np.float64)
        found["travel"] = f"a move reaches {_range(reached)} of {len(model.viewpoints)} viewpoints"
    if model.repeat.any():
        found["repeat"] = f"a look repeats the last label with probability {_range(model.repeat)}"
    if model.observe_after_decision:
        found["scans"] = "one follows each decision"
    if model.information_gain > 0.0:
        found["information"] = f"{model.information_gain:g} per nat"
    if model.empty is not None:
        found["empty cups"] = f"class {model.empty}"
    return found


def _range(numbers: NDArray[np.float64]) -> str:
    low, high = numbers.min() + 0.0, numbers.max() + 0.0  # no -0
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
