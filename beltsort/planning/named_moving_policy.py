"""Policies for moving belts by name, `most-urgent:0.9` for example, or `module:object` for one's own."""

from collections.abc import Callable
from pathlib import Path

from beltsort._core import ArgumentError, MovingBelt, MovingPlanner, MovingThreshold
from beltsort.planning.named_policy import named_policy, own_policy
from beltsort.planning.policy import MovingPolicy
from beltsort.planning.stop_and_go import StopAndGo, stop_and_go_belt
from beltsort.util.naming import nearest_name
from beltsort.util.references import is_reference

DEFAULT_TRIALS = 30
STOP_AND_GO = "stop-and-go"
HELP = (
    f"moving-search[:TRIALS] (default {DEFAULT_TRIALS}), most-urgent:T, falling-threshold:HIGH:LOW, "
    f"information-per-tick:T, {STOP_AND_GO}:POLICY (the belt stands while the arm looks; POLICY as in "
    "`beltsort compare`, threshold:0.94 for example), module:object (a policy of your own, or a class or "
    "function that is called with the belt)"
)


def named_moving_policy(
    text: str, belt: MovingBelt, folder: Path | None = None
) -> tuple[MovingBelt, MovingPolicy]:
    """Return the policy with a name, and the belt that it is for.

    Parameters
    ----------
    text
        A kind and its parameters, separated by colons: see `HELP`.
    belt
        A belt of constant speed.
    folder
        Where modules are found that are not installed; default: the working folder.

    Returns
    -------
    belt : MovingBelt
        The belt given; for `stop-and-go` that of `stop_and_go_belt`.
    policy : MovingPolicy
        The policy.

    Raises
    ------
    ArgumentError
        If the kind is unknown or does not have these parameters, or `module:object` is no policy.

    Examples
    --------
    >>> import beltsort
    >>> belt = beltsort.MovingBelt(beltsort.models.paper(), ticks_per_place=4)
    >>> named_moving_policy("falling-threshold:0.95:0.7", belt)[1]
    MovingThreshold(high=0.95, low=0.7, rule="most-urgent")
    """
    folder = folder or Path()
    kind, *parameters = text.split(":")
    if kind == STOP_AND_GO:
        standing = stop_and_go_belt(belt)
        return standing, StopAndGo(named_policy(":".join(parameters), belt.model, folder))
    if kind not in KINDS and is_reference(text):
        policy: MovingPolicy = own_policy(text, belt, folder)
        return belt, policy
    if kind not in KINDS:
        near = nearest_name(kind, [*KINDS, STOP_AND_GO])
        raise ArgumentError(f"there is no policy {text!r}; did you mean {near!r}? Expected one of {HELP}")
    try:
        return belt, KINDS[kind](belt, *parameters)
    except (TypeError, ValueError) as reason:
        raise ArgumentError(f"{text!r} is not a valid policy ({reason}), expected one of {HELP}") from reason


KINDS: dict[str, Callable[..., MovingPolicy]] = {
    "moving-search": lambda belt, trials=DEFAULT_TRIALS: MovingPlanner(belt, trials=int(trials)),
    "most-urgent": lambda belt, threshold: MovingThreshold(belt, float(threshold)),
    "falling-threshold": lambda belt, high, low: MovingThreshold(belt, float(high), float(low)),
    "information-per-tick": lambda belt, threshold: MovingThreshold(
        belt, float(threshold), rule="information-per-tick"
    ),
}
