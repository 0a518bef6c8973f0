"""The sweep file (TOML): its keys and their checks."""

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from beltsort._core import DEFAULT_BATCH_SIZE, DEFAULT_BATCHES
from beltsort.errors import SweepError
from beltsort.sim.config import TABLE_OBJECTS, TRAINING_OBJECTS
from beltsort.util.extras import extra
from beltsort.util.problems import Problem, listed
from beltsort.util.validation import StrictModel, validated

with extra("sweep"):
    from pydantic import BeforeValidator, Field

Count = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0, lt=2**63)]


def _seeds(given: object) -> object:
    """Return the list of seeds that the number of them stands for."""
    return list(range(given)) if type(given) is int else given


Seeds = Annotated[list[Seed], Field(min_length=1), BeforeValidator(_seeds)]


class Tables(StrictModel):
    """What one row simulates at level `tables`: as of `beltsort.evaluate`."""

    batches: Count = DEFAULT_BATCHES
    """Number of simulated batches."""
    batch_size: Count = DEFAULT_BATCH_SIZE
    """Decisions in a batch."""
    true_classes: list[str] | None = None
    """Classes to draw objects from uniformly; the arrival prior if missing."""


class Scans(StrictModel):
    """What one row simulates at level `scans`: a run with a classifier trained on other objects."""

    objects: Count = 10
    """Objects of a run."""
    drawn_from: list[str] | None = None
    """Classes to draw them from uniformly; all if missing."""
    training_objects: Count = TRAINING_OBJECTS
    """Objects per class, viewpoint and position that the classifier is trained on."""
    table_objects: Count = TABLE_OBJECTS
    """Independent objects per row of the observation tables."""


class SweepFile(StrictModel):
    """The whole file; `docs/sweep.md` describes it."""

    level: Literal["tables", "scans"] = "tables"
    """Where labels come from: drawn from the tables, or scans of the simulated cell."""
    seeds: Seeds = Field(default_factory=lambda: [0])
    """Seeds, or how many of them."""
    model: dict[str, Any] = Field(default_factory=dict)
    """Parameters of the model, each a value or a list of values."""
    planner: dict[str, Any] = Field(default_factory=dict)
    """Policies, and parameters of `despot`."""
    cell: dict[str, Any] = Field(default_factory=dict)
    """Parameters of the simulated cell."""
    tables: Tables = Tables()
    """What one row simulates at level `tables`."""
    scans: Scans = Scans()
    """What one row simulates at level `scans`."""


def read_sweep(path: Path) -> SweepFile:
    """Read a sweep file.

    Raises
    ------
    SweepError
        If it cannot be read, is not TOML, or has unknown keys or invalid values.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as reason:
        raise SweepError(
            f"the sweep {path} cannot be read: {reason}; expected a TOML file, see docs/sweep.md"
        ) from reason

    def error(problems: Sequence[Problem]) -> SweepError:
        return SweepError(f"the sweep {path}: {listed(problems)}")

    return validated(SweepFile, content, error)
