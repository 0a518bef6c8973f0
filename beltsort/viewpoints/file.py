"""The file of a viewpoint map: JSON, one line per key.

`viewpoints` (name, index of its point, position, `world_from_camera`), `motion_cost` and `travel` are what
cells and models read; `graph` and `sampling` are what they follow from. Positions, poses, costs and travel
are repeated for the reader's convenience: a file in which they contradict the graph is refused.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from beltsort.errors import ViewpointError
from beltsort.viewpoints.plain import array_of, fields_of, list_of, of_type, short
from beltsort.viewpoints.sphere import Sampling

SAMPLING_KEYS = {"method": str, "count": int, "radius": float, "seed": int}
GRAPH_KEYS = ("points", "reachable", "edges")
VIEWPOINT_KEYS = ("name", "point", "position", "world_from_camera")
OWN_KEYS = {"lowest": float, "note": str, "neighbours_only": bool}
KEYS = ("viewpoints", "motion_cost", "travel", "sampling", *OWN_KEYS, "graph")

ROUNDING = 1e-6  # by which a repeated number may differ from what it follows from


def text_of(data: dict[str, Any]) -> str:
    """Return the text of a file."""
    lines = (f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in data.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def read_plain(path: Path) -> dict[str, Any]:
    """Read a file's keys, all of them and no others."""
    try:
        given = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as reason:
        raise ViewpointError(f"cannot be read: {reason}; write it with `beltsort viewpoints`") from reason
    return dict(zip(KEYS, fields_of(given, KEYS, "the file"), strict=True))


def parts_of(given: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of `ViewpointMap`."""
    points, reachable, edges = fields_of(given["graph"], GRAPH_KEYS, "graph")
    sampling = fields_of(given["sampling"], list(SAMPLING_KEYS), "sampling")
    typed = zip(SAMPLING_KEYS.items(), sampling, strict=True)
    names, chosen = [], []
    for k, viewpoint in enumerate(list_of(given["viewpoints"], "viewpoints")):
        name, point, _, _ = fields_of(viewpoint, VIEWPOINT_KEYS, f"viewpoints[{k}]")
        names.append(of_type(name, str, f"viewpoints[{k}].name"))
        chosen.append(of_type(point, int, f"viewpoints[{k}].point"))
    return {
        "points": array_of(points, np.float64, 3, "graph.points"),
        "reachable": array_of(reachable, np.bool_, None, "graph.reachable"),
        "edges": array_of(edges, np.int64, 2, "graph.edges"),
        "chosen": tuple(chosen),
        "names": tuple(names),
        "sampling": Sampling(
            **{key: of_type(value, kind, f"sampling.{key}") for (key, kind), value in typed}
        ),
        **{key: of_type(given[key], kind, key) for key, kind in OWN_KEYS.items()},
    }


def check_repeated(given: dict[str, Any], implied: dict[str, Any]) -> None:
    """Refuse positions, poses, costs and travel that do not follow from the rest of the file."""
    for key in ("viewpoints", "motion_cost", "travel"):
        if not _alike(given[key], implied[key]):
            raise ViewpointError(
                f"{key} does not follow from the graph: it is {short(given[key])}, expected "
                f"{short(implied[key])}; write the file anew with `beltsort viewpoints`, or give "
                "SortingModel your own numbers"
            )


def _alike(given: Any, implied: Any) -> bool:
    """Whether two pieces of plain data are equal but for rounding."""
    if isinstance(implied, dict):
        return isinstance(given, dict) and all(_alike(given[key], implied[key]) for key in implied)
    if isinstance(implied, list):
        return (
            isinstance(given, list)
            and len(given) == len(implied)
            and all(_alike(a, b) for a, b in zip(given, implied, strict=True))
        )
    if isinstance(implied, str):
        return bool(given == implied)
    return isinstance(given, (int, float)) and abs(given - implied) <= ROUNDING
