"""The parameters that a sweep can vary, by their dotted names."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from inspect import signature
from typing import Any

from beltsort import SortingModel
from beltsort.errors import SweepError
from beltsort.sim import CellConfig
from beltsort.util.naming import nearest_of

OF_TABLES = {"p_obs", "labels", "modes", "label_rule", "counts", "smoothing"}
NOT_VARIED = {"classes", "viewpoints", "note"} | OF_TABLES
DESPOT = ("planner.scenarios", "planner.depth")


def _leaves(settings: object, prefix: str) -> list[str]:
    """Name the fields of a configuration that are no configurations themselves."""
    if not is_dataclass(settings):
        return [prefix]
    return [
        name
        for field in fields(settings)
        for name in _leaves(getattr(settings, field.name), f"{prefix}.{field.name}")
    ]


KNOWN = (
    "model.file",
    "model.positions",
    *(f"model.{name}" for name in signature(SortingModel).parameters if name not in NOT_VARIED),
    "planner.policy",
    *DESPOT,
    *_leaves(CellConfig(), "cell"),
)


def axes_of(sections: Mapping[str, Mapping[str, Any]]) -> dict[str, list[Any]]:
    """Return the values of each parameter, in the order of the file.

    Parameters
    ----------
    sections
        Nested tables, `{"cell": {"arm": {"angle": [0.1, 0.4]}}}` for example. A list holds a parameter's
        values, anything else is its one value.

    Raises
    ------
    SweepError
        If a parameter is unknown, with the nearest one named, or has no values.
    """
    axes = {}
    for name, value in _flat(sections, ""):
        if name not in KNOWN:
            section = [known for known in KNOWN if known.split(".")[0] == name.split(".")[0]]
            raise SweepError(f"there is no parameter {name!r}; {nearest_of(name, section)}")
        axes[name] = value if isinstance(value, list) else [value]
        if not axes[name]:
            raise SweepError(
                f"{name} has no values, so the grid is empty; give at least one, or leave it out"
            )
    return axes


def _flat(value: Any, name: str) -> list[tuple[str, Any]]:
    if not isinstance(value, Mapping) or name in KNOWN:
        return [(name, value)]
    return [leaf for key, part in value.items() for leaf in _flat(part, f"{name}.{key}" if name else key)]


def section_of(point: Mapping[str, Any], section: str) -> dict[str, Any]:
    """Return the parameters of one section, without its name."""
    prefix = f"{section}."
    return {name.removeprefix(prefix): value for name, value in point.items() if name.startswith(prefix)}


def nested(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Return dotted names as nested dictionaries.

    Examples
    --------
    >>> nested({"arm.angle": 0.1, "upstream": 1})
    {'arm': {'angle': 0.1}, 'upstream': 1}
    """
    result: dict[str, Any] = {}
    for name, value in flat.items():
        *path, last = name.split(".")
        inner = result
        for part in path:
            inner = inner.setdefault(part, {})
        inner[last] = value
    return result
