"""Studies: the paper's, and those of a model and of policies of one's own, which run the same experiments."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from beltsort import ArgumentError, BeltsortError, SortingModel, solve
from beltsort.paper.design import FULL, Design
from beltsort.paper.instances import PAPER, Instance, Objects, penalty_of
from beltsort.paper.outcomes import LABELS
from beltsort.paper.outline import THE_PAPER, Outline, Source, positions_in_words
from beltsort.paper.policies import POLICIES, check_own, papers_policy

OWN = "own"
PROBED = 0.01
"""Seconds given to the offline solver to tell whether it values the actions of a model."""

TICKS = 6
"""Names of penalties that an axis has room for, and one more."""

OF_BULBS = (
    "Depth scans, and the studies beyond the paper's (bonus for information, wrong tables, arrival prior, "
    "belts that never stop), are of the paper's bulbs and are left out."
)


@dataclass(frozen=True)
class Study:
    """What is sorted, and what is varied.

    Attributes
    ----------
    outline
        Positions, policies and names.
    instance
        The tables.
    design
        Penalties, discounts, sizes.
    optimum_positions
        Numbers of positions for which the offline solution is computed.
    """

    outline: Outline
    instance: Instance
    design: Design
    optimum_positions: tuple[int, ...]


def papers_study(design: Design = FULL) -> Study:
    """Return the paper's study in a design."""
    return Study(THE_PAPER, PAPER, design, THE_PAPER.positions)


def own_study(
    model: SortingModel,
    name: str,
    design: Design = FULL,
    *,
    policies: Sequence[str] = (),
    positions: Sequence[int] | None = None,
    r_min: Sequence[float] | None = None,
) -> Study:
    """Return the paper's study of a model and of policies of one's own.

    A penalty replaces the largest loss of putting an object into a bin of other classes; smaller ones change
    in proportion. Bins where no class belongs keep their rewards. Claims are tested at the model's own
    penalty, objects are drawn from its arrival prior, and its discount is kept.

    Parameters
    ----------
    model
        Any number of classes, viewpoints, positions, labels and bins.
    name
        What the report calls it.
    design
        Sizes; its penalties, which suit a reward of 10, are scaled to the model's largest reward.
    policies
        Names of further policies; see `beltsort.planning.named_policy`.
    positions
        Numbers of belt positions seen at once; default one and all.
    r_min
        Penalties; the model's own is added.

    Raises
    ------
    ArgumentError
        If positions, penalties or policies are none that the model can be simulated with, or if no decision
        of the model costs anything.
    """
    own = penalty_of(model)
    numbers = _positions(model, positions)
    penalties = _penalties(model, own, design.r_min if r_min is None else r_min, scaled=r_min is None)
    seen = {number: model.with_positions(number) for number in numbers}
    for policy in policies:
        for each in seen.values():
            check_own(policy, each, policies)
    papers, left_out = _papers_policies(list(seen.values()))
    optimum, unsolved = _solvable(seen)
    designed = replace(
        design,
        r_min=penalties,
        r_min_optimum=tuple(r for r in penalties if r in (penalties[0], own, penalties[-1])),
        r_min_scans=(own,),
        r_min_discounts=(own,),
        r_min_compared=own,
        discounts=(model.discount,),
        bonuses=(),
        positions=(),
        sharpness=(),
        arrivals=(),
        speeds=(),
    )
    outline = Outline(
        name=OWN,
        title=f"Sorting objects from a conveyor belt: the paper's experiments with {name}",
        tables={OWN: name},
        sources=(Source(f"labels from the tables of {name}", LABELS, OWN),),
        objects=(Objects(_classes_in_words(model), tuple(model.classes)),),
        positions=numbers,
        policies=(*papers, *policies),
        r_min=own,
        ticks=_ticks(penalties),
        left_out=(OF_BULBS, *left_out, *unsolved),
    )
    return Study(outline, Instance(OWN, model), designed, optimum)


def _positions(model: SortingModel, positions: Sequence[int] | None) -> tuple[int, ...]:
    found = sorted({1, model.positions} if positions is None else set(positions))
    if not found or found[0] < 1 or found[-1] > model.positions:
        raise ArgumentError(
            f"positions are {', '.join(map(str, found))}; give numbers from 1 to {model.positions}, which is "
            "how many the model has tables for"
        )
    return tuple(found)


def _penalties(model: SortingModel, own: float, given: Sequence[float], *, scaled: bool) -> tuple[float, ...]:
    factor = float(model.reward.max()) / float(PAPER.model.reward.max()) if scaled else 1.0
    found = sorted({own, *(factor * each for each in given)})
    if found[0] <= 0.0:
        raise ArgumentError(f"r_min contains {found[0]:g}; a penalty is a number above 0")
    if len(found) < 2:
        raise ArgumentError(f"r_min is {own:g} only, the model's own; give others, to compare with it")
    return tuple(found)


def _papers_policies(models: Sequence[SortingModel]) -> tuple[list[str], list[str]]:
    """Return the paper's policies that can be made for all models, and a sentence on each of the others."""
    found, left_out = [], []
    for name in POLICIES:
        try:
            for model in models:
                papers_policy(name, model)
        except BeltsortError as reason:
            left_out.append(f"{name} is left out: {_cause(reason)}.")
        else:
            found.append(name)
    return found, left_out


def _solvable(models: dict[int, SortingModel]) -> tuple[tuple[int, ...], list[str]]:
    """Return for how many positions the optimum is known well enough to compare actions with, and why not."""
    found, left_out = [], []
    for number, model in models.items():
        seen = positions_in_words(number)
        try:
            values_actions = solve(model, seconds=PROBED).values_actions
        except BeltsortError as reason:
            left_out.append(f"The offline solution with {seen} is left out: {_cause(reason)}.")
            continue
        if values_actions:
            found.append(number)
        else:
            left_out.append(
                f"The offline solution with {seen} is left out: such a model has too many states for the "
                "value of every action; it is known for one or two positions with the same moves everywhere."
            )
    return tuple(found), left_out


def _cause(reason: BeltsortError) -> str:
    """Return what an error says without the remedy, which does not apply to a study."""
    return str(reason.__cause__ or reason).partition(";")[0]


def _classes_in_words(model: SortingModel) -> str:
    return f"{len(model.classes)} class{'es' if len(model.classes) > 1 else ''}"


def _ticks(penalties: Sequence[float]) -> tuple[float, ...]:
    """Return penalties that are not too near each other on a logarithmic axis, both ends among them.

    Examples
    --------
    >>> _ticks((5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 350.0, 500.0))
    (5.0, 20.0, 50.0, 200.0, 500.0)
    """
    first, *_, last = penalties
    apart = (last / first) ** (1.0 / TICKS)
    found = [first]
    for penalty in penalties:
        if penalty >= apart * found[-1] and last >= apart * penalty:
            found.append(penalty)
    return (*found, last)
