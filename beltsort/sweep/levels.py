"""The simulation of one point: labels drawn from tables, or whole scans."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import beltsort
from beltsort import Policy, SortingModel, models
from beltsort.errors import SweepError
from beltsort.planning.decisions import right_bins
from beltsort.planning.named_policy import named_policy
from beltsort.sim import CellConfig
from beltsort.sim.prepare import Prepared, Recipe, StageProgress, prepare
from beltsort.sweep.grid import inputs_of, seeds_of
from beltsort.sweep.parameters import nested, section_of
from beltsort.util.naming import index_of
from beltsort.util.problems import Problem, listed
from beltsort.util.validation import validated

Point = Mapping[str, Any]
METRICS = ("steps", "correct", "returns", "discounted_returns")


def table_point(point: Point) -> dict[str, float | None]:
    """Return means and standard errors over batches whose labels are drawn from the tables."""
    _check_inputs(point)
    settings = section_of(point, "tables")
    world, planning = seeds_of(point, 2)
    model = model_of(point)
    summary = beltsort.evaluate(
        model,
        policy_of(point, model, planning),
        batches=settings["batches"],
        batch_size=settings["batch_size"],
        seed=world,
        threads=1,
        true_classes=_indices(settings["true_classes"], model),
    ).summary()
    means = {name: summary[name]["mean"] for name in METRICS}
    errors = {f"{name}_error": summary[name]["standard_error"] for name in METRICS}
    return {name: value if np.isfinite(value) else None for name, value in {**means, **errors}.items()}


def scan_point(point: Point) -> dict[str, int | float]:
    """Sort objects in the simulated cell, from scans to decisions, and return the counts."""
    from beltsort.perception import perception_for
    from beltsort.sim import SimulatedCell
    from beltsort.sorting.journal import Journal
    from beltsort.sorting.loop import sort_objects

    _check_inputs(point)
    settings = section_of(point, "scans")
    world, planning, drawing = seeds_of(point, 3)
    config, prepared = config_of(point), prepared_for(point)
    model = model_of(point, prepared)
    classes = _indices(settings["drawn_from"], model) or range(len(model.classes))
    labels = [int(i) for i in np.random.default_rng(drawing).choice(list(classes), settings["objects"])]
    cell = SimulatedCell(labels, config, seed=world, bin_names=model.bins)
    perception = perception_for(model, config.layout, prepared.database)
    with TemporaryDirectory() as folder, Journal(Path(folder) / "journal.sqlite") as journal:
        report = sort_objects(
            cell, perception, policy_of(point, model, planning), model, journal, objects=len(labels)
        )
    right, decided = right_bins(model), [d for d in report.decisions if d.label is not None]
    return {
        "steps": report.steps,
        "decided": len(decided),
        "correct": sum(bool(right[d.label, labels[d.object]]) for d in decided),
        "skipped": len(report.skipped),
        "looks": sum(d.looks for d in report.decisions),
    }


def model_of(point: Point, prepared: Prepared | None = None) -> SortingModel:
    """Return the model that a point plans with: its file's, or the cell's own, with the point's changes."""
    changes = section_of(point, "model")
    file, positions = changes.pop("file", None), changes.pop("positions", None)
    if file is not None or prepared is None:
        model = models.load(file)
    else:
        config = config_of(point)
        model = prepared.counts.model(config.classes, [viewpoint.name for viewpoint in config.viewpoints])
    if positions is not None:
        model = model.with_positions(positions)
    return model.replace(**changes) if changes else model


def policy_of(point: Point, model: SortingModel, seed: int) -> Policy:
    """Return the policy that a point names."""
    settings = section_of(point, "planner")
    policy = settings.pop("policy")
    if policy.split(":")[0] != "despot":
        return named_policy(policy, model)
    return named_policy(policy, model, seed=seed, threads=1, **settings)


def config_of(point: Point) -> CellConfig:
    """Return the settings of a point's cell.

    Raises
    ------
    SweepError
        If a value is of another kind than the parameter.
    """

    def error(problems: Sequence[Problem]) -> SweepError:
        return SweepError(listed([Problem(f"cell.{where}", what) for where, what in problems]))

    return validated(CellConfig, nested(section_of(point, "cell")), error)


def prepared_for(point: Point, progress: StageProgress | None = None) -> Prepared:
    """Return classifier and tables of a point's cell, from the cache if they are there."""
    settings = section_of(point, "scans")
    recipe = Recipe(
        config_of(point),
        training_objects=settings["training_objects"],
        table_objects=settings["table_objects"],
    )
    return prepare(recipe, progress=progress)


def _check_inputs(point: Point) -> None:
    """Refuse files that are not what they were when the sweep began, or on the machine where it began."""
    if inputs_of(point) != point["inputs"]:
        raise SweepError(
            "a file that the point names has changed since the sweep began, or differs between machines; "
            "expected the same everywhere: begin again, or copy it"
        )


def _indices(names: list[str] | None, model: SortingModel) -> list[int] | None:
    return None if names is None else [index_of(name, model.classes, "class") for name in names]
