"""`_repr_html_` of the classes of the extension."""

from functools import singledispatch

from beltsort._core import (
    Belief,
    Despot,
    Evaluation,
    InformationGain,
    LookAhead,
    OneObject,
    Plan,
    Solution,
    SortingModel,
    Threshold,
)
from beltsort.planning.bins import Estimate
from beltsort.planning.display.facts import Policy, certified, facts, objects_left, settings_of, sizes
from beltsort.planning.explanation import action_in_words
from beltsort.util.html import box, table
from beltsort.util.text import position_number

MOST_ACTIONS = 12  # of a plan that are shown, the best first


@singledispatch
def html(thing: object) -> str:
    """Return what a notebook shows of an object: a small fragment of HTML, names escaped."""
    raise TypeError(f"{type(thing).__name__} has no HTML")


@html.register
def _(model: SortingModel) -> str:
    return box(f"SortingModel: {sizes(model)}", table([*facts(model).items()], numbers=False))


@html.register
def _(belief: Belief) -> str:
    model, probabilities = belief.model, belief.probabilities.tolist()
    rows = [[position_number(j), *(f"{p:.3f}" for p in row)] for j, row in enumerate(probabilities)]
    left = "" if belief.remaining is None else f", {objects_left(belief.remaining)}"
    parts = [table(rows, header=["position", *model.classes], shades=probabilities)]
    last = belief.last_labels.tolist()
    if any(label >= 0 for row in last for label in row):
        names = [
            [position_number(j), *("" if z < 0 else model.labels[z] for z in row)]
            for j, row in enumerate(last)
        ]
        parts.append(table(names, header=["last label from", *model.viewpoints], numbers=False))
    return box(f"Belief{left}", *parts)


@html.register
def _(plan: Plan) -> str:
    best_first = sorted(plan.values.items(), key=lambda entry: -entry[1])
    best = best_first[0][1]
    rows = [
        [action_in_words(plan.model, action), f"{value:.2f}", f"{best - value:.2f}"]
        for action, value in best_first
    ]
    chosen = [action for action, _ in best_first].index(plan.action)
    more = f"; {len(rows) - MOST_ACTIONS} more actions" if len(rows) > MOST_ACTIONS else ""
    trials = f"{plan.trials} trials in {plan.seconds:.3f} s"
    return box(
        f"Plan: {action_in_words(plan.model, plan.action)}",
        table(rows[:MOST_ACTIONS], header=["action", "value", "gap to the best"], bold=chosen),
        remark=f"Optimal value {certified(plan)} (certified); {trials}{more}.",
    )


@html.register(Despot)
@html.register(InformationGain)
@html.register(LookAhead)
@html.register(OneObject)
@html.register(Threshold)
def _(policy: Policy) -> str:
    settings = {"model": sizes(policy.model), **settings_of(policy)}
    rows = [[name, str(value)] for name, value in settings.items()]
    return box(type(policy).__name__, table(rows, numbers=False))


@html.register
def _(solution: Solution) -> str:
    rows = [
        ["model", sizes(solution.model)],
        ["optimal value", f"from {solution.lower:.4f} to {solution.upper:.4f}, at the arrival prior"],
        ["found in", f"{solution.seconds:.1f} s"],
    ]
    return box("Solution", table(rows, numbers=False))


@html.register
def _(evaluation: Evaluation) -> str:
    rows = [
        [metric.replace("_", " "), str(Estimate(found["mean"], found["standard_error"]))]
        for metric, found in evaluation.summary().items()
    ]
    batches = len(evaluation.steps)
    counted = "1 batch" if batches == 1 else f"{batches} batches"
    return box(f"Evaluation of {counted}", table(rows, header=["per batch", "mean ± standard error"]))
