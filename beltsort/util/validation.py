"""Check plain data from a file and turn it into typed settings.

pydantic checks types, ranges and required keys. This module translates its errors into messages that say
where the problem is, what was found, what is expected and, for an unknown key, the nearest known one.
"""

import json
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, get_args, get_type_hints

from beltsort._core import BeltsortError
from beltsort.util.extras import extra
from beltsort.util.naming import nearest_of
from beltsort.util.problems import Problem

with extra("cell"):
    from pydantic import (
        BaseModel,
        ConfigDict,
        ValidationError,
        ValidatorFunctionWrapHandler,
        WrapValidator,
        create_model,
    )
    from pydantic_core import ErrorDetails

LONGEST = 60  # characters of a value in a message

Settings = TypeVar("Settings")

STRICT = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)
"""No unknown keys, no text for numbers; the docstrings under the keys appear in messages."""


class StrictModel(BaseModel):
    """A model without unknown keys, whose values must have exactly the types of its fields."""

    model_config = STRICT


def _as_value_error(given: object, check: ValidatorFunctionWrapHandler) -> object:
    try:
        return check(given)
    except BeltsortError as reason:
        raise ValueError(str(reason)) from reason


OWN_CHECKS = WrapValidator(_as_value_error)
"""For a field whose dataclass checks itself: its errors are reported together with all others."""


def validated(
    kind: type[Settings], given: object, error: Callable[[list[Problem]], BeltsortError]
) -> Settings:
    """Return `given` as a `kind`.

    Parameters
    ----------
    kind
        A `StrictModel` or a dataclass. Its fields are the known keys; their types and checks apply.
    given
        Plain data, as `tomllib` and `json` return it.
    error
        Makes the exception to raise from the problems that were found.

    Raises
    ------
    BeltsortError
        What `error` returns, for all problems at once: unknown and missing keys, values of a wrong type or
        out of range. A dataclass that checks itself, without `OWN_CHECKS`, stops at its first problem.
    """
    # The envelope's configuration makes dataclasses strict as well.
    envelope = create_model("Envelope", __config__=STRICT, content=(kind, ...))
    # As JSON, in whose strict mode a list may become a tuple but text never a number.
    text = json.dumps({"content": given}, default=str)
    try:
        content: Settings = dict(envelope.model_validate_json(text))["content"]
    except ValidationError as invalid:
        raise error([_problem(kind, details) for details in invalid.errors()]) from None
    except BeltsortError as reason:
        raise error([Problem("", str(reason))]) from reason
    return content


def shortened(value: object) -> str:
    """Return the beginning of a value's `repr`, at most 60 characters."""
    text = repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _problem(kind: type[object], details: ErrorDetails) -> Problem:
    path = list(details["loc"][1:])  # without the envelope's own key
    key = str(path[-1]) if path else ""
    where = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(".")
    table = _table_at(kind, path[:-1])
    known = _descriptions(table)
    description = known.get(key) if isinstance(path[-1] if path else None, str) else None
    meaning = f": {' '.join(description.split()).rstrip('.')}" if description else ""
    found, context = shortened(details["input"]), details.get("ctx", {})
    match details["type"]:
        case "extra_forbidden" | "unexpected_keyword_argument":
            remedy = nearest_of(key, list(known)) if known else "leave it out"
            return Problem(where, f"is an unknown key; {remedy}")
        case "missing":
            return Problem(where, f"is missing; add it{meaning}")
        case "json_invalid":  # text that JSON can write but UTF-8 cannot
            return Problem("", f"cannot be read: {details['msg']}")
        case "value_error":
            return Problem(where, str(context["error"]))
        case "model_type" | "dataclass_type":
            keys = ", ".join(_descriptions(_table_at(kind, path)))
            return Problem(where, f"is {found}, expected a table with the keys {keys}{meaning}")
        case "too_short":
            return Problem(where, f"is {found}, expected at least {context['min_length']} entries{meaning}")
        case "too_long":
            return Problem(where, f"is {found}, expected at most {context['max_length']} entries{meaning}")
    expected = details["msg"].removeprefix("Input should ").removeprefix("be ")
    return Problem(where, f"is {found}, expected {expected}{meaning}")


def _table_at(table: type[object] | None, path: list[int | str]) -> type[object] | None:
    """Return the type of the table that a path leads to from `table`."""
    for step in path:
        if isinstance(step, str):
            table = _table_in(_annotations(table).get(step))
    return table


def _table_in(annotation: Any) -> type[object] | None:
    """Return the model or dataclass within an annotation: `Viewpoint` of `tuple[Viewpoint, ...]`."""
    if isinstance(annotation, type) and (issubclass(annotation, BaseModel) or is_dataclass(annotation)):
        return annotation
    return next(filter(None, map(_table_in, get_args(annotation))), None)


def _annotations(table: type[object] | None) -> dict[str, Any]:
    if table is not None and issubclass(table, BaseModel):
        return {name: field.annotation for name, field in table.model_fields.items()}
    return get_type_hints(table) if is_dataclass(table) else {}


def _descriptions(table: Any) -> dict[str, str | None]:
    """Return the known keys of a table, each with the docstring under it if it has one."""
    if table is None:
        return {}
    if issubclass(table, BaseModel):
        return {name: field.description for name, field in table.model_fields.items()}
    return {field.name: None for field in fields(table)}
