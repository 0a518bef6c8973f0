"""`repr` of the classes of the extension: one line, or a small table."""

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
from beltsort.util.text import position_number, text_table

WIDEST = 100  # characters of a row of probabilities
LIKELIEST = 4  # classes of a position, where a row of all is wider


@singledispatch
def text(thing: object) -> str:
    """Return what `repr` shows of an object.

    Examples
    --------
    >>> import beltsort
    >>> from beltsort.models import paper
    >>> text(beltsort.Threshold(paper(), 0.94, viewpoint="p3"))
    "Threshold(<4 classes, 3 viewpoints, 2 positions>, threshold=0.94, viewpoint='p3')"
    """
    raise TypeError(f"{type(thing).__name__} has no text")


@text.register
def _(model: SortingModel) -> str:
    return "\n".join([f"SortingModel: {sizes(model)}", *_aligned(list(facts(model).items()))])


@text.register
def _(belief: Belief) -> str:
    left = "" if belief.remaining is None else f", {objects_left(belief.remaining)}"
    return "\n".join([f"Belief{left}", *belief_lines(belief), *_last_labels(belief)])


@text.register
def _(plan: Plan) -> str:
    action = action_in_words(plan.model, plan.action)
    value, trials = plan.values[plan.action], f"{plan.trials} trial{'' if plan.trials == 1 else 's'}"
    return f"Plan({action}, value {value:.2f}, optimum {certified(plan)}, {trials})"


@text.register(Despot)
@text.register(InformationGain)
@text.register(LookAhead)
@text.register(OneObject)
@text.register(Threshold)
def _(policy: Policy) -> str:
    given = (f"{name}={value!r}" for name, value in settings_of(policy).items())
    return f"{type(policy).__name__}({', '.join([f'<{sizes(policy.model)}>', *given])})"


@text.register
def _(solution: Solution) -> str:
    bounds = f"optimum from {solution.lower:.4f} to {solution.upper:.4f}"
    return f"Solution(<{sizes(solution.model)}>, {bounds}, {solution.seconds:.1f} s)"


@text.register
def _(evaluation: Evaluation) -> str:
    batches = len(evaluation.steps)
    rows = [
        [metric.replace("_", " "), str(Estimate(found["mean"], found["standard_error"]))]
        for metric, found in evaluation.summary().items()
    ]
    counted = "1 batch" if batches == 1 else f"{batches} batches, mean ± standard error"
    return "\n".join([f"Evaluation of {counted}", text_table(rows)])


def _aligned(rows: list[tuple[str, str]]) -> list[str]:
    width = max(len(name) for name, _ in rows)
    return [f"  {name.ljust(width)}  {what}" for name, what in rows]


def belief_lines(belief: Belief) -> list[str]:
    """Return a row of probabilities per position, or its likeliest classes where a row is too wide."""
    classes, probabilities = belief.model.classes, belief.probabilities
    numbers = [[position_number(j), *(f"{p:.3f}" for p in row)] for j, row in enumerate(probabilities)]
    table = text_table([["position", *classes], *numbers]).splitlines()
    if len(table[0]) <= WIDEST:
        return table
    likeliest = (-probabilities).argsort(axis=1, kind="stable")[:, :LIKELIEST]
    return _aligned(
        [
            (
                f"position {position_number(j)}",
                ", ".join(f"{classes[c]} {probabilities[j, c]:.3f}" for c in row) + ", ...",
            )
            for j, row in enumerate(likeliest.tolist())
        ]
    )


def _last_labels(belief: Belief) -> list[str]:
    """Return a line per position with labels that a look may repeat."""
    model, lines = belief.model, []
    for j, row in enumerate(belief.last_labels.tolist()):
        seen = [
            f"{model.labels[label]} from {viewpoint}"
            for viewpoint, label in zip(model.viewpoints, row, strict=True)
            if label >= 0
        ]
        if seen:
            lines.append(f"  last labels of position {position_number(j)}: {', '.join(seen)}")
    return lines
