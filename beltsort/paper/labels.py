"""Experiments whose labels are drawn from observation tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from beltsort import Evaluation, SortingModel, evaluate
from beltsort.paper.design import Design, Stream, seed_of
from beltsort.paper.instances import CELL, PAPER, Instance, Objects, with_penalty
from beltsort.paper.outcomes import LABELS, STUDY, Point, Row
from beltsort.paper.outline import THE_PAPER, Outline
from beltsort.paper.policies import BATCH, RECOMMENDED, policy_at, source_of
from beltsort.planning.decisions import right_bins


def label_points(
    design: Design, seed: int, instances: Sequence[Instance], outline: Outline = THE_PAPER
) -> list[Point]:
    """Return the points of Fig. 4 to 7: every policy, number of positions, set of objects and penalty."""
    return [
        label_point(
            design,
            seed,
            with_penalty(instance.model.with_positions(positions), r_min).replace(discount=discount),
            objects,
            study=outline.name,
            instance=instance.name,
            r_min=r_min,
            policy=policy,
            batches=batches,
        )
        for instance in instances
        for discount, r_mins, batches in _discounts(design, instance)
        for objects in outline.objects
        for positions in outline.positions
        for r_min in r_mins
        for policy in outline.policies
    ]


def _discounts(design: Design, instance: Instance) -> list[tuple[float, tuple[float, ...], int]]:
    """Return (discount, penalties, batches) of an instance."""
    first, *others = design.discounts
    if instance.name == CELL:
        return [(first, design.r_min, design.batches_cell)]
    repeated = [(discount, design.r_min_discounts, design.batches_discounts) for discount in others]
    return [(first, design.r_min, design.batches), *repeated]


def label_point(design: Design, seed: int, model: SortingModel, objects: Objects, **settings: Any) -> Point:
    """Return the point of a model; `settings` are further keys, or other values of those given here."""
    source = source_of(settings.get("policy", RECOMMENDED))
    return {
        "study": STUDY,
        "setting": None,
        "level": LABELS,
        "instance": PAPER.name,
        "objects": objects.name,
        "true_classes": objects.labels(model),
        "positions": model.positions,
        "discount": model.discount,
        "r_min": model.r_min,
        "model": model.to_json(),
        "truth": None,
        "policy": RECOMMENDED,
        "trials": design.trials,
        "batches": design.batches_beyond,
        "batches_tuning": design.batches_tuning,
        "seed": seed_of(seed, Stream.LABELS),
        "seed_tuning": seed_of(seed, Stream.TUNING),
        **({} if source is None else {"source": source}),
        **settings,
    }


def simulate_labels(point: Mapping[str, Any]) -> Row:
    """Run a point; with the point's own keys, what is returned is a row."""
    model = SortingModel.from_json(point["model"])
    policy, parameter = policy_at(point, model)
    truth = None if point["truth"] is None else SortingModel.from_json(point["truth"])
    result = evaluate(
        model,
        policy,
        batches=point["batches"],
        batch_size=BATCH,
        seed=point["seed"],
        threads=1,
        true_classes=point["true_classes"],
        truth=truth,
    )
    return {"parameter": parameter, **outcomes_of(model, result)}


def outcomes_of(model: SortingModel, result: Evaluation) -> Row:
    """Return the outcomes of every batch as plain lists.

    Objects in bins where no class belongs, such as a manual bin, are neither right nor wrong.
    """
    right = right_bins(model)
    wrong = right.any(axis=1, keepdims=True) & ~right  # (B, L)
    return {
        "steps": result.steps.tolist(),
        "positives": result.correct.tolist(),
        "negatives": result.confusion.astype(int)[:, wrong].sum(axis=1).tolist(),
        "returns": result.returns.tolist(),
    }
