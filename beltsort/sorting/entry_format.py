"""How the journal keeps its entries: written as plain data by `plain`, read by `content_of`."""

from collections.abc import Mapping
from dataclasses import asdict, fields
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypedDict, get_args

from beltsort._core import Belief
from beltsort.cell.commands import Act
from beltsort.sorting.command import Command
from beltsort.sorting.entries import AnyContent, Intended, Snapshot
from beltsort.util.extras import extra

if TYPE_CHECKING:
    from pydantic import TypeAdapter

COMMANDS = {Intended.kind: "command", Snapshot.kind: "pending"}
"""Fields that hold a command, by the entry's kind."""

SNAPSHOT_NAMES = {"scans": "glances", "missed_arrivals": "strays", "next": "owed", "known_outcome": "told"}
"""Fields of a snapshot that journals keep under another name, the one that the format gave them first."""


def plain(content: AnyContent) -> dict[str, Any]:
    """Return the fields of an entry as plain data, fit for JSON."""
    left_out = {field.name for field in fields(content) if field.default is None}
    data = {
        name: value for name, value in asdict(content).items() if value is not None or name not in left_out
    }
    match content:
        case Intended(command=Command() as command) | Snapshot(pending=Command() as command):
            data[COMMANDS[content.kind]] = stored(command)
    return _renamed(data, SNAPSHOT_NAMES) if isinstance(content, Snapshot) else data


def content_of(kind: str, data: Mapping[str, Any]) -> AnyContent:
    """Return the entry whose fields `plain` returned.

    Raises
    ------
    ValueError
        If the kind is unknown, or a field is missing, unknown or of another type.
    """
    with extra("cell"):
        from pydantic import ValidationError  # to write a journal it is not needed

    adapter = _adapters().get(kind)
    if adapter is None:
        raise ValueError(f"its kind is {kind!r}, expected one of {', '.join(_adapters())}")
    field = COMMANDS.get(kind)
    if field is not None and isinstance(data, Mapping) and isinstance(command := data.get(field), Mapping):
        data = {**data, field: restored(command)}
    if kind == Snapshot.kind and isinstance(data, Mapping):
        data = _renamed(data, {stored: name for name, stored in SNAPSHOT_NAMES.items()})
    try:
        return adapter.validate_python(data)
    except ValidationError as reason:
        faults = (f"{'.'.join(map(str, fault['loc']))}: {fault['msg'].lower()}" for fault in reason.errors())
        raise ValueError(", ".join(faults)) from reason


def _renamed(data: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Return data of which some fields have other names."""
    return {names.get(name, name): value for name, value in data.items()}


@lru_cache(maxsize=1)
def _adapters() -> dict[str, "TypeAdapter[AnyContent]"]:
    """Return what reads each kind of entry."""
    with extra("cell"):
        from pydantic import TypeAdapter

    forms: dict[str, Any] = {}
    for form in get_args(AnyContent):
        forms[form.kind] = forms[form.kind] | form if form.kind in forms else form
    return {kind: TypeAdapter(form) for kind, form in forms.items()}


ACTS: dict[str, type[Act]] = {act.verb: act for act in get_args(Act)}
"""By the names that journals give them."""


def stored(command: Command) -> dict[str, Any]:
    """Return a command as journals keep it.

    Examples
    --------
    >>> from beltsort.cell import SortInto
    >>> stored(Command("5e-sort-3", SortInto(2), boot_id="a"))["name"]
    'sort'
    """
    return {
        "id": command.id,
        "name": command.act.verb,
        "target": command.act.target,
        "boot_id": command.boot_id,
        "arriving": command.arriving,
        "attempt": command.attempt,
    }


def restored(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a command that a journal has kept, of which only the act is checked.

    Raises
    ------
    ValueError
        If there is no such act.
    """
    name, target = data.get("name"), data.get("target")
    if not isinstance(name, str) or name not in ACTS:
        raise ValueError(f"the command's name is {name!r}, expected one of {', '.join(ACTS)}")
    if not isinstance(target, int):
        raise ValueError(f"the target of {name} is {target!r}, expected a number")
    others = {key: value for key, value in data.items() if key not in ("name", "target")}
    return {**others, "act": ACTS[name](target)}


class PlainBelief(TypedDict):
    """A belief as entries store it: see `beltsort.sorting.entries.Scanned`."""

    belief: list[list[float]]
    kinds: list[list[float]] | None
    last_labels: list[list[int]]


def plain_belief(belief: Belief) -> PlainBelief:
    """Return a belief as the fields of entries from which it is restored exactly."""
    probabilities, kinds = belief.probabilities.tolist(), belief.kinds.tolist()
    return {
        "belief": probabilities,
        "kinds": None if len(kinds[0]) == len(probabilities[0]) else kinds,
        "last_labels": belief.last_labels.tolist(),
    }
