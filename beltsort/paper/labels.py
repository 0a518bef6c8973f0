"""Experiments whose labels are drawn from observation tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from beltsort import Evaluation, SortingModel, evaluate
from beltsort.paper.design import Design, Stream, seed_of
from beltsort.paper.instances import OBJECTS, PAPER, Instance, Objects
from beltsort.paper.outcomes import Point, Row
from beltsort.paper.policies import BATCH, POLICIES, RECOMMENDED, policy_at

LEVEL = "labels from tables"
STUDY = "paper"


def label_points(design: Design, seed: int, instances: Sequence[Instance]) -> list[Point]:
    """Return the points of Fig. 4 to 7: every policy, one and two positions, both sets of objects."""
    return [
        label_point(
            design,
            seed,
            instance.model.with_positions(positions).replace(r_min=r_min, discount=discount),
            objects,
            instance=instance.name,
            policy=policy,
            batches=batches,
        )
        for instance in instances
        for discount, r_mins, batches in _discounts(design, instance)
        for objects in OBJECTS
        for positions in (1, 2)
        for r_min in r_mins
        for policy in POLICIES
    ]


def _discounts(design: Design, instance: Instance) -> list[tuple[float, tuple[float, ...], int]]:
    """Return (discount, penalties, batches) of an instance."""
    first, *others = design.discounts
    if instance is not PAPER:
        return [(first, design.r_min, design.batches_cell)]
    repeated = [(discount, design.r_min_discounts, design.batches_discounts) for discount in others]
    return [(first, design.r_min, design.batches), *repeated]


def label_point(design: Design, seed: int, model: SortingModel, objects: Objects, **settings: Any) -> Point:
    """Return the point of a model; `settings` are further keys, or other values of those given here."""
    return {
        "study": STUDY,
        "setting": None,
        "level": LEVEL,
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
    return {"parameter": parameter, **outcomes_of(result)}


def outcomes_of(result: Evaluation) -> Row:
    """Return the outcomes of every batch as plain lists."""
    return {
        "steps": result.steps.tolist(),
        "positives": result.correct.tolist(),
        "negatives": (BATCH - result.correct.astype(int)).tolist(),
        "returns": result.returns.tolist(),
    }
