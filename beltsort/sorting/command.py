"""One attempt at having an actuator act, and how the journal keeps it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, get_args

from beltsort.cell.commands import Act


@dataclass(frozen=True)
class Command:
    """One attempt at an act.

    Attributes
    ----------
    id
        Unique for the device, and for the attempt.
    act
        What is to be done.
    boot_id
        Of the device before it was sent.
    arriving
        Whether it only brings the camera to where the planner takes it to be: no planner step, and no look.
    attempt
        Counts from 1.
    """

    id: str
    act: Act
    boot_id: str
    arriving: bool = False
    attempt: int = 1

    def again(self, boot_id: str) -> "Command":
        """Return the next attempt. Its id is new: a device acts on an id at most once.

        Examples
        --------
        >>> from beltsort.cell.commands import SortInto
        >>> first = Command("5e-sort-3", SortInto(2), boot_id="a")
        >>> first.again("a").id, first.again("a").again("b").id
        ('5e-sort-3.2', '5e-sort-3.3')
        """
        base = self.id.removesuffix(f".{self.attempt}") if self.attempt > 1 else self.id
        attempt = self.attempt + 1
        return replace(self, id=f"{base}.{attempt}", boot_id=boot_id, attempt=attempt)


ACTS: dict[str, type[Act]] = {act.verb: act for act in get_args(Act)}
"""By the names that journals give them."""


def stored(command: Command) -> dict[str, Any]:
    """Return a command as journals keep it.

    Examples
    --------
    >>> from beltsort.cell.commands import SortInto
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
    if name not in ACTS:
        raise ValueError(f"the command's name is {name!r}, expected one of {', '.join(ACTS)}")
    if not isinstance(target, int):
        raise ValueError(f"the target of {name} is {target!r}, expected a number")
    others = {key: value for key, value in data.items() if key not in ("name", "target")}
    return {**others, "act": ACTS[name](target)}
