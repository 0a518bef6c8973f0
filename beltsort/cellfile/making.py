"""Making the devices of a cell file."""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.problems import CellFileError, raise_all
from beltsort.cellfile.registry import Backend, backend
from beltsort.cellfile.roles import TABLES


@dataclass
class Maker:
    """Creates the devices of a cell; one that several roles share is created once.

    Attributes
    ----------
    description
        The cell file.
    on_made
        Called with every device that a back-end has created.
    made
        Back-end, options and device of each.
    """

    description: CellDescription
    on_made: Callable[[Any], None]
    made: list[tuple[Backend, Mapping[str, object], Any]] = field(default_factory=list)

    def device(self, role: str, kind: Backend) -> Any:
        """Return the device of a role; one with the same options is shared if the back-end says so.

        Raises
        ------
        CellFileError
            If the options do not fit.
        """
        options = self.description.options_of(role)
        for same_kind, same_options, device in self.made:
            if kind.shared and (same_kind, same_options) == (kind, options):
                return device
        try:
            device = kind.make(options, self.description)
        except CellFileError as error:
            raise error.below(lambda key: self._table_of(role, key)) from None
        self.made.append((kind, options, device))
        self.on_made(device)
        return device

    def _table_of(self, role: str, key: str) -> str:
        """Return the table of the cell file that contains an option, or to which a missing one belongs."""
        name = self.description.device(role).backend
        shared = self.description.backends.get(name, {})
        own = f"{TABLES[role]}.options"
        return f"backends.{name}" if not key or re.split(r"[.[]", key)[0] in shared else own


def backends_of(description: CellDescription) -> dict[str, Backend]:
    """Return the back-end of each role of a cell.

    Raises
    ------
    CellFileError
        With the problems of all roles.
    """
    return all_of(description.roles, lambda role: backend(role, description.device(role).backend))


def all_of(roles: Iterable[str], make: Callable[[str], Any]) -> dict[str, Any]:
    """Return the result of `make` for each role, or raise one error with the problems of all roles."""
    made, errors = {}, []
    for role in roles:
        try:
            made[role] = make(role)
        except CellFileError as error:
            errors.append(error)
    raise_all(errors)
    return made


def roles_in_dry_run(description: CellDescription, *, live: bool) -> tuple[str, ...]:
    """Return the roles of the devices whose commands are printed instead of sent.

    Raises
    ------
    CellFileError
        If there is no such back-end.
    """
    if live:
        return ()
    return tuple(
        TABLES[role]
        for role in description.roles
        if role != "camera" and not backend(role, description.device(role).backend).harmless
    )
