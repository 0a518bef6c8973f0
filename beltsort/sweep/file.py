"""The file of a sweep, read and checked."""

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from beltsort.errors import SweepError
from beltsort.util.naming import nearest_of

Count = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0, lt=2**63)]


def _counted(seeds: Any) -> Any:
    """Write a number of seeds as the seeds from 0 on."""
    return list(range(seeds)) if type(seeds) is int else seeds


Seeds = Annotated[list[Seed], Field(min_length=1), BeforeValidator(_counted)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Tables(_Strict):
    """What one row simulates at level `tables`: as of `beltsort.evaluate`."""

    batches: Count = 1000
    batch_size: Count = 10
    true_classes: list[str] | None = None


class Scans(_Strict):
    """What one row simulates at level `scans`: a run of so many objects, with a classifier trained on others.

    `drawn_from` are the classes of the objects, all if missing.
    """

    objects: Count = 10
    drawn_from: list[str] | None = None
    training_objects: Count = 40
    table_objects: Count = 100


class SweepFile(_Strict):
    """The whole file; `docs/sweep.md` describes it."""

    level: Literal["tables", "scans"] = "tables"
    seeds: Seeds = [0]
    model: dict[str, Any] = {}
    planner: dict[str, Any] = {}
    cell: dict[str, Any] = {}
    tables: Tables = Tables()
    scans: Scans = Scans()


def read_sweep(path: Path) -> SweepFile:
    """Read a sweep file.

    Raises
    ------
    SweepError
        If it cannot be read, is no TOML, or says what a sweep file cannot say.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as reason:
        raise SweepError(
            f"the sweep {path} cannot be read: {reason}; expected a TOML file, see docs/sweep.md"
        ) from reason
    try:
        return SweepFile.model_validate(content)
    except ValidationError as error:
        raise SweepError(f"the sweep {path}: {'; '.join(_complaints(error))}") from None


def _complaints(error: ValidationError) -> list[str]:
    """Say what is wrong where, and which key was probably meant."""
    return [
        _unknown(*map(str, wrong["loc"]))
        if wrong["type"] == "extra_forbidden"
        else f"{'.'.join(map(str, wrong['loc']))} is {wrong['input']!r}: {wrong['msg']}"
        for wrong in error.errors()
    ]


def _unknown(*where: str) -> str:
    sections: dict[str, type[BaseModel]] = {"tables": Tables, "scans": Scans}
    known = sections.get(where[0], SweepFile).model_fields
    return f"there is no key {'.'.join(where)!r}; {nearest_of(where[-1], list(known))}"
