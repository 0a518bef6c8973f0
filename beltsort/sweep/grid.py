"""From a sweep file to the points of its grid."""

import hashlib
import itertools
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from beltsort.errors import SweepError
from beltsort.planning.named_policy import located_policy, plans_by_the_clock, solution_file
from beltsort.sweep.file import SweepFile
from beltsort.sweep.parameters import DESPOT, axes_of

WORLD = ("model.", "cell.")
SEED_BITS = 63  # a seed must fit into a signed 64-bit integer, as in Parquet


def points_of(sweep: SweepFile, folder: Path) -> list[dict[str, Any]]:
    """Return one point for each combination of values and each seed.

    Policies meet the same objects and labels: a point's `spawn_key` is its index along each axis of model and
    cell parameters, which the planner's do not enter. New values at the end of an axis change no other point.

    Parameters
    ----------
    sweep
        Content of the file.
    folder
        The file's folder; relative paths in the file start there.

    Raises
    ------
    SweepError
        If a parameter is unknown, has no values or does not apply to the level, no policy is named, a policy
        has a time budget, or a file is missing.
    """
    axes = axes_of({"model": sweep.model, "planner": sweep.planner, "cell": sweep.cell})
    _check(sweep, axes)
    settings = _settings(sweep)
    worlds = [_located(world, folder) for world in _product(axes, WORLD)]
    indices = _product({name: list(range(len(values))) for name, values in axes.items()}, WORLD)
    planners = [_located(planner, folder) for planner in _planners(axes)]
    return [
        {
            "level": sweep.level,
            **world,
            **planner,
            **settings,
            "inputs": inputs_of({**world, **planner}),
            "seed": seed,
            "spawn_key": list(index.values()),
        }
        for world, index in zip(worlds, indices, strict=True)
        for planner in planners
        for seed in dict.fromkeys(sweep.seeds)
    ]


def seeds_of(point: Mapping[str, Any], number: int) -> list[int]:
    """Spawn independent seeds for a point, the same wherever and whenever it is run."""
    sequence = np.random.SeedSequence(point["seed"], spawn_key=tuple(point["spawn_key"]))
    return [int(state) >> (64 - SEED_BITS) for state in sequence.generate_state(number, np.uint64)]


def inputs_of(point: Mapping[str, Any]) -> str | None:
    """Return a hash of the contents of the files that a point names, None if it names none.

    Raises
    ------
    SweepError
        If a file cannot be read.
    """
    files = [path for name, value in sorted(point.items()) for path in _files(name, value)]
    content = hashlib.sha256()
    for file in files:
        try:
            content.update(hashlib.sha256(Path(file).read_bytes()).digest())
        except OSError as reason:
            raise SweepError(f"the file {file} cannot be read: {reason}; correct the sweep") from reason
    return content.hexdigest()[:16] if files else None


def _check(sweep: SweepFile, axes: Mapping[str, list[Any]]) -> None:
    policies = axes.get("planner.policy")
    if policies is None:
        raise SweepError('no policy is named, so the grid is empty; write [planner] policy = ["one-object"]')
    for policy in policies:
        if not isinstance(policy, str):
            raise SweepError(f'a policy is {policy!r}, expected a word: "threshold:0.94" for example')
        if plans_by_the_clock(policy):
            raise SweepError(
                f"the policy {policy!r} plans by the clock, so its rows would depend on the machine; give "
                "trials (despot:300), or a file that `beltsort solve` wrote (solution:FILE)"
            )
    foreign = [name for name in axes if name.startswith("cell.")]
    if sweep.level == "tables" and foreign:
        raise SweepError(f'{foreign[0]} means nothing to labels drawn from tables; write level = "scans"')
    if sweep.level == "tables" and "model.file" not in axes:
        raise SweepError('no model is named; write [model] file = "model.json"')


def _settings(sweep: SweepFile) -> dict[str, Any]:
    values: dict[str, Any] = (sweep.tables if sweep.level == "tables" else sweep.scans).model_dump()
    return {f"{sweep.level}.{name}": value for name, value in values.items()}


def _product(axes: Mapping[str, list[Any]], sections: tuple[str, ...]) -> list[dict[str, Any]]:
    chosen = {name: values for name, values in axes.items() if name.startswith(sections)}
    return [dict(zip(chosen, values, strict=True)) for values in itertools.product(*chosen.values())]


def _planners(axes: Mapping[str, list[Any]]) -> list[dict[str, Any]]:
    """Return the planners; parameters of `Despot` do not multiply the other policies."""
    planners = [
        planner
        if planner["planner.policy"].split(":")[0] == "despot"
        else {name: None if name in DESPOT else value for name, value in planner.items()}
        for planner in _product(axes, ("planner.",))
    ]
    return [planner for number, planner in enumerate(planners) if planner not in planners[:number]]


def _located(values: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the values with absolute paths."""
    located = dict(values)
    if "model.file" in located:
        located["model.file"] = str(folder / located["model.file"])
    if "cell.meshes" in located:
        located["cell.meshes"] = {
            name: str(folder / files) if isinstance(files, str) else [str(folder / file) for file in files]
            for name, files in located["cell.meshes"].items()
        }
    if "planner.policy" in located:
        located["planner.policy"] = located_policy(located["planner.policy"], folder)
    return located


def _files(name: str, value: Any) -> Iterable[str]:
    match name:
        case "model.file":
            yield value
        case "cell.meshes":
            for files in value.values():
                yield from [files] if isinstance(files, str) else files
        case "planner.policy" if (file := solution_file(value)) is not None:
            yield file
