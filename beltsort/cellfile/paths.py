"""Options that are paths, which start at the cell file's folder."""

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from beltsort.cellfile.description import CellDescription

FILES = ("certificate", "private_key", "trust", "path", "setup")
"""Options that are paths."""

PROGRAMS = ("python",)
"""Options that are paths if they contain a slash, and otherwise names of programs on the PATH."""

Options = TypeVar("Options", bound=Any)


def resolved(options: Options, cell: "CellDescription") -> Options:
    """Return the options with paths resolved relative to the cell file."""
    values = {field.name: getattr(options, field.name) for field in fields(options)}
    paths = {name: str(cell.path(value)) for name, value in values.items() if _is_path(name, value)}
    changed: Options = replace(options, **paths)
    return changed


def _is_path(name: str, value: Any) -> bool:
    return (name in FILES and bool(value)) or (name in PROGRAMS and "/" in value)
