"""Back-ends by name.

beltsort's own stand in a table here: a source checkout has no metadata of its own, or that of an older
install. Those of third parties are found by entry points, one group for each kind of device::

    [project.entry-points."beltsort.arm"]
    acme = "acme_beltsort:ARM"

whose object is a `Backend`, best made by `backend_of`. beltsort's own names come first.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, TypeVar

from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.validation import validated
from beltsort.util.naming import nearest_of

if TYPE_CHECKING:
    from beltsort.cellfile.description import CellDescription

Options = TypeVar("Options")

ROLES = ("arm", "camera", "belt", "sorter")
GROUP = "beltsort."

BUILT_IN: dict[str, dict[str, str]] = {
    "simulated": dict.fromkeys(ROLES, "beltsort.cellfile.simulated:BACKEND"),
    "opcua": dict.fromkeys(("belt", "sorter"), "beltsort.cellfile.backends:OPCUA"),
    "modbus": dict.fromkeys(("belt", "sorter"), "beltsort.cellfile.backends:MODBUS"),
    "ros1": {role: f"beltsort.cellfile.backends:ROS1_{role.upper()}" for role in ROLES},
    "replay": dict.fromkeys(("arm", "camera", "belt"), "beltsort.cellfile.backends:REPLAY"),
    "dry-run": {role: f"beltsort.cellfile.dry_run:{role.upper()}" for role in ROLES},
}
"""Where the back-end of each device is, by the back-end's name."""


@dataclass(frozen=True)
class Backend:
    """How devices of one kind are made, and what a cell must know of them.

    Attributes
    ----------
    make
        From the back-end's options, as the file gives them, and the cell to a device: an `Arm`, a
        `DepthCamera`, a `Belt`, a `Sorter`, or several of them at once.
    shared
        Whether one device serves all that name this back-end with the same options.
    harmless
        Whether it moves nothing real, and so needs no `--live`.
    absent
        Whether nothing is there that could move: a camera stays where it is, whatever the arm is told.
    """

    make: Callable[[Mapping[str, object], "CellDescription"], Any]
    shared: bool = False
    harmless: bool = False
    absent: bool = False


def backend_of(
    options: type[Options],
    make: Callable[[Options, "CellDescription"], Any],
    *,
    shared: bool = False,
    harmless: bool = False,
    absent: bool = False,
) -> Backend:
    """Return a back-end whose options are a frozen dataclass of plain fields.

    Parameters
    ----------
    options
        The dataclass; what the file gives is checked against its fields and their types.
    make
        From such options and the cell to a device.
    shared, harmless, absent
        As in `Backend`.
    """
    return Backend(lambda given, cell: make(validated(options, given), cell), shared, harmless, absent)


def backend(role: str, name: str) -> Backend:
    """Return the back-end of a device.

    Parameters
    ----------
    role
        `arm`, `camera`, `belt` or `sorter`.
    name
        As in the cell file.

    Raises
    ------
    CellFileError
        If there is none of this name, or it cannot be loaded.
    """
    known = _entry_points(role)
    where = f"{role}.backend"
    if name not in known:
        raise CellFileError.of(
            where, f"is {name!r}, which is no back-end of this device; {nearest_of(name, list(known))}"
        )
    try:
        found = known[name].load()
    except (ImportError, AttributeError) as reason:
        raise CellFileError.of(
            where, f"is {name!r}, which cannot be loaded: {reason}; install what it needs"
        ) from reason
    if not isinstance(found, Backend):
        raise CellFileError.of(
            where, f"is {name!r}, whose entry point is {found!r}, expected a Backend: ask its maker"
        )
    return found


def _entry_points(role: str) -> dict[str, EntryPoint]:
    """Return the back-ends of a device by name, beltsort's own first."""
    group = GROUP + role
    own = {name: EntryPoint(name, places[role], group) for name, places in BUILT_IN.items() if role in places}
    return own | {entry.name: entry for entry in entry_points(group=group) if entry.name not in own}
