"""Plain data from a file made into typed settings, and what is wrong with it told in words.

Types, ranges and required keys are pydantic's work; here its findings get the words that every error of
beltsort has: where, what was found, what is expected, the nearest known key.
"""

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, get_args, get_type_hints

from pydantic import (
    BaseModel,
    ConfigDict,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    create_model,
)
from pydantic_core import ErrorDetails

from beltsort import BeltsortError
from beltsort.cellfile.problems import CellFileError, Problem
from beltsort.util.naming import nearest_of

Settings = TypeVar("Settings")

STRICT = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)
"""No unknown keys, no text for numbers; the docstrings under the keys appear in messages."""


def _told(given: object, check: ValidatorFunctionWrapHandler) -> object:
    try:
        return check(given)
    except BeltsortError as reason:
        raise ValueError(str(reason)) from reason


OWN_CHECKS = WrapValidator(_told)
"""For a field whose dataclass checks itself and has numbers only: its errors are told with all others."""


class Section(BaseModel):
    """A table of the cell file."""

    model_config = STRICT


def validated(kind: type[Settings], given: Mapping[str, object]) -> Settings:
    """Return `given` as a `kind`, which is a `Section` or a dataclass of plain fields.

    Parameters
    ----------
    kind
        Its fields are the known keys; their types and checks are kept.
    given
        Plain data: what `tomllib` returns.

    Raises
    ------
    CellFileError
        With all problems at once: unknown and missing keys, values of a wrong type or out of range.

    Examples
    --------
    >>> from beltsort.sorting.rules import Rules
    >>> validated(Rules, {"max_looks": 20}).max_looks
    20
    >>> validated(Rules, {"max_looks": "20"})
    Traceback (most recent call last):
    ...
    beltsort.cellfile.problems.CellFileError: max_looks: is '20', expected a valid integer
    """
    envelope = create_model("Envelope", __config__=STRICT, content=(kind, ...))
    # As JSON, in whose strict mode a list may become a tuple but text never a number.
    text = json.dumps({"content": given}, default=str)
    try:
        content: Settings = dict(envelope.model_validate_json(text))["content"]
    except ValidationError as findings:
        raise CellFileError([_problem(kind, finding) for finding in findings.errors()]) from None
    except BeltsortError as reason:  # from a dataclass that checks itself
        raise CellFileError.of("", str(reason)) from reason
    return content


def _problem(kind: type[object], finding: ErrorDetails) -> Problem:
    _, *path = finding["loc"]
    parent = _table_at(kind, path[:-1])
    key = str(path[-1]) if path else ""
    found, where = _short(finding["input"]), _dotted(path)
    match finding["type"]:
        case "extra_forbidden" | "unexpected_keyword_argument":
            known = list(_keys(parent))
            return Problem(where, f"is an unknown key; {nearest_of(key, known) if known else 'leave it out'}")
        case "missing":
            return Problem(where, f"is missing; add it{_meaning(parent, key)}")
        case "value_error":
            return Problem(where, str(finding["ctx"]["error"]))
    expected = finding["msg"].removeprefix("Input should ").removeprefix("be ")
    return Problem(where, f"is {found}, expected {expected}{_meaning(parent, key)}")


def _dotted(path: list[int | str]) -> str:
    """Return `viewpoints[1].name` for ["viewpoints", 1, "name"]."""
    steps = (f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return "".join(steps).removeprefix(".")


def _meaning(parent: type[object] | None, key: str) -> str:
    """Return what a key is, where its docstring tells."""
    description = _keys(parent).get(key)
    return f": {' '.join(description.split()).rstrip('.')}" if description else ""


def _keys(table: type[object] | None) -> dict[str, str | None]:
    """Return the known keys of a table, and what they are."""
    if table is None:
        return {}
    if issubclass(table, BaseModel):
        return {name: field.description for name, field in table.model_fields.items()}
    return {field.name: None for field in _dataclass_fields(table)}


def _table_at(table: type[object] | None, path: list[int | str]) -> type[object] | None:
    """Return the kind of the table that a path from `table` leads to."""
    for step in path:
        if isinstance(step, str):
            table = _table_in(_annotations(table).get(step))
    return table


def _annotations(table: type[object] | None) -> dict[str, Any]:
    if table is not None and issubclass(table, BaseModel):
        return {name: field.annotation for name, field in table.model_fields.items()}
    return get_type_hints(table) if is_dataclass(table) else {}


def _table_in(annotation: Any) -> type[object] | None:
    """Return the table that an annotation speaks of: `Viewpoint` of `tuple[Viewpoint, ...]`."""
    if isinstance(annotation, type) and (issubclass(annotation, BaseModel) or is_dataclass(annotation)):
        return annotation
    return next(filter(None, map(_table_in, get_args(annotation))), None)


def _dataclass_fields(table: Any) -> tuple[Any, ...]:
    return fields(table)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
