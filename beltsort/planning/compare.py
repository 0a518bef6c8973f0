"""Simulation of several policies on the same objects."""

from collections.abc import Callable, Mapping, Sequence

from numpy.typing import ArrayLike

from beltsort._core import (
    DEFAULT_BATCH_SIZE,
    DEFAULT_BATCHES,
    DEFAULT_MAX_LOOKS,
    ArgumentError,
    Solution,
    SortingModel,
    evaluate,
)
from beltsort.planning.comparison import Comparison, check_known
from beltsort.planning.loss_bound import loss_bound
from beltsort.planning.policy import Policy


def compare(
    model: SortingModel,
    policies: Mapping[str, Policy],
    *,
    batches: int = DEFAULT_BATCHES,
    batch_size: int = DEFAULT_BATCH_SIZE,
    seed: int = 0,
    threads: int | None = None,
    viewpoint: int | str = 0,
    true_classes: ArrayLike | None = None,
    truth: SortingModel | None = None,
    max_looks: int = DEFAULT_MAX_LOOKS,
    reference: Solution | None = None,
    belt_ends: bool = False,
    baseline: str | None = None,
    metrics: Sequence[str] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Comparison:
    """Evaluate policies on the same batches.

    Random numbers are indexed by (batch, object, look), so that every policy gets the same objects. Paired
    differences have much smaller standard errors than differences of means. Tune a baseline on other seeds
    than those of the comparison.

    Parameters
    ----------
    model, batches, batch_size, seed, threads, viewpoint, true_classes, truth, max_looks, belt_ends
        As in `evaluate`.
    reference
        A solution of the model, of any size. With it, the comparison tells how much each policy loses at most
        (`Comparison.loss_bounds`), on objects drawn from the model; make batches long enough for the rewards
        after them not to count. If it values actions, regrets are compared as well, as in `evaluate`.
    policies
        At least two policies, by name.
    baseline
        Name of the policy that the others are compared with; default the first.
    metrics
        Names of properties of `Evaluation` to compare; default all that are unbiased. With many metrics, some
        differ significantly by chance.
    progress
        Called with the number of policies evaluated and the total number, first with 0.

    Returns
    -------
    Comparison
        The evaluation of every policy, with means and paired differences.

    Raises
    ------
    ArgumentError
        If there is no mapping, or one of fewer than two policies, the baseline or a metric is unknown, the
        reference can bound neither regrets nor losses, or `evaluate` rejects an argument.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> policies = {f"threshold {t}": beltsort.Threshold(model, t) for t in (0.9, 0.99)}
    >>> comparison = beltsort.compare(model, policies, batches=100, metrics=["steps", "correct"])
    >>> comparison.difference("threshold 0.99", "correct").mean > 0
    True
    """
    if not isinstance(policies, Mapping):
        raise ArgumentError(
            f"policies is a {type(policies).__name__}, expected a dict of policies by name: write "
            '{"one": first, "other": second}'
        )
    if len(policies) < 2:
        raise ArgumentError(
            f"{len(policies)} policies are given, expected at least two to compare; give more"
        )
    names = list(policies)
    chosen = names[0] if baseline is None else baseline
    check_known("policy", chosen, names)
    drawn_from_model = true_classes is None and (truth is None or truth == model)
    if reference is not None:
        _check_reference(reference, model, drawn_from_model, belt_ends)
    if progress is not None:
        progress(0, len(policies))
    evaluations = {}
    for done, (name, policy) in enumerate(policies.items(), start=1):
        evaluations[name] = evaluate(
            model,
            policy,
            batches=batches,
            batch_size=batch_size,
            seed=seed,
            threads=threads,
            viewpoint=viewpoint,
            true_classes=true_classes,
            truth=truth,
            max_looks=max_looks,
            reference=reference if reference is not None and reference.values_actions else None,
            belt_ends=belt_ends,
        )
        if progress is not None:
            progress(done, len(policies))
    unbiased = list(evaluations[chosen].summary())
    compared = unbiased if metrics is None else list(metrics)
    for metric in compared:
        check_known("metric", metric, unbiased)
    losses = {}
    if reference is not None and drawn_from_model:
        losses = {name: loss_bound(result, reference, viewpoint) for name, result in evaluations.items()}
    return Comparison(model, evaluations, chosen, tuple(compared), batch_size, seed, losses)


def _check_reference(
    reference: Solution, model: SortingModel, drawn_from_model: bool, belt_ends: bool
) -> None:
    reference.check_solves(model)
    if belt_ends:
        raise ArgumentError(
            "a reference bounds the value of belts that never end, and belt_ends has policies plan for one "
            "that does; leave one of them out"
        )
    if not reference.values_actions and not drawn_from_model:
        raise ArgumentError(
            "the reference is of a model with more than two positions, or with viewpoints that differ in "
            "their moves: it only bounds losses on objects and labels drawn from the model; leave out "
            "true_classes and truth, or the reference"
        )
