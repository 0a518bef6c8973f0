"""The file of a viewpoint map: JSON, one line per key.

`viewpoints`, `motion_cost` and `travel` are what cells and models read; `graph` and `sampling` are what they
follow from. Positions, poses, costs and travel are repeated for the reader's convenience: a file in which
they contradict the graph is refused.
"""

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Annotated, Any

from beltsort.errors import ViewpointError
from beltsort.util.extras import extra
from beltsort.util.problems import Problem, listed
from beltsort.util.validation import StrictModel, shortened, validated

with extra("cell"):
    from pydantic import Field

ROUNDING = 1e-6  # by which a repeated number may differ from what it follows from
MOST_PROBLEMS = 8  # in a message

Three = Annotated[list[float], Field(min_length=3, max_length=3)]
Four = Annotated[list[float], Field(min_length=4, max_length=4)]
Index = Annotated[int, Field(ge=0, lt=2**32)]
Pair = Annotated[list[Index], Field(min_length=2, max_length=2)]


class ViewpointEntry(StrictModel):
    """A chosen viewpoint."""

    name: str
    """What the viewpoint is called."""
    point: int
    """Index of its point in the graph."""
    position: Three
    """x, y, z of the camera, metres."""
    world_from_camera: Annotated[list[Four], Field(min_length=4, max_length=4)]
    """The camera's pose, four rows of four numbers."""


class SamplingEntry(StrictModel):
    """The attributes of a `Sampling`."""

    method: str
    """How points are spread: fibonacci or uniform."""
    count: int
    """Number of points."""
    radius: float
    """Distance of the camera from the belt end, metres."""
    seed: int
    """Of uniform points."""


class GraphEntry(StrictModel):
    """The sampled points and which of them are neighbours."""

    points: list[Three]
    """x, y, z of each point, metres."""
    reachable: list[bool]
    """Whether the arm reaches each point."""
    edges: list[Pair]
    """Pairs of neighbours, indices of points."""


class ViewpointFile(StrictModel):
    """The whole file. All keys are required."""

    viewpoints: list[ViewpointEntry]
    """The chosen viewpoints."""
    motion_cost: list[list[float]]
    """Cost of the move from each viewpoint to each other one."""
    travel: list[list[int]]
    """For each viewpoint, the viewpoints that one move reaches."""
    sampling: SamplingEntry
    """How the half-sphere was sampled."""
    lowest: float
    """Elevation below which no point counts as reachable, degrees."""
    note: str
    """A remark on the arm."""
    neighbours_only: bool
    """Whether one move only reaches a viewpoint's neighbours."""
    graph: GraphEntry
    """The sampled points and which of them are neighbours."""

    @classmethod
    def read(cls, path: str | PathLike[str]) -> "ViewpointFile":
        """Read a file; whether its parts fit together is not checked yet.

        Raises
        ------
        ViewpointError
            If the file cannot be read, or keys are unknown, missing or of a wrong type.
        """
        try:
            given = json.loads(Path(path).read_text("utf-8"))
        except (OSError, ValueError) as reason:
            raise ViewpointError(f"cannot be read: {reason}; write it with `beltsort viewpoints`") from reason
        return validated(cls, given, _error)

    def write(self, path: str | PathLike[str]) -> None:
        """Write the file; an existing one is replaced."""
        lines = (f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in self.model_dump().items())
        Path(path).write_text("{\n" + ",\n".join(lines) + "\n}\n")

    def check_against(self, implied: "ViewpointFile") -> None:
        """Raise a `ViewpointError` if what the file repeats differs from what follows from its graph."""
        ours, theirs = self.model_dump(), implied.model_dump()
        for key in ("viewpoints", "motion_cost", "travel"):
            if not _equal(ours[key], theirs[key]):
                raise ViewpointError(
                    f"{key} does not follow from the graph: it is {shortened(ours[key])}, expected "
                    f"{shortened(theirs[key])}; write the file anew with `beltsort viewpoints`, or give "
                    "SortingModel your own numbers"
                )


def _error(problems: Sequence[Problem]) -> ViewpointError:
    more = len(problems) - MOST_PROBLEMS
    text = listed(problems[:MOST_PROBLEMS])
    return ViewpointError(f"{text}\nand {more} more problems" if more > 0 else text)


def _equal(a: Any, b: Any) -> bool:
    """Whether two pieces of data of the same types are equal up to rounding."""
    if isinstance(a, Mapping):
        return all(_equal(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(_equal, a, b))
    return bool(a == b if isinstance(a, str) else abs(a - b) <= ROUNDING)
