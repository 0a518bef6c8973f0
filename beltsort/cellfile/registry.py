"""Back-ends by name.

The built-in back-ends are in the table `BUILT_IN`, since a source checkout has no metadata, or those of an
older installation. Third-party back-ends are found by entry points, one group for each kind of device::

    [project.entry-points."beltsort.arm"]
    acme = "acme_beltsort:ARM"

An entry point refers to a `Backend`, which `backend_of` creates. Built-in names take precedence.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, TypeVar

from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.roles import DIVERTER, ROLES, TABLES
from beltsort.cellfile.validation import validated
from beltsort.util.naming import nearest_of

if TYPE_CHECKING:
    from beltsort.cellfile.description import CellDescription

Options = TypeVar("Options")

GROUP = "beltsort."

BUILT_IN: dict[str, dict[str, str]] = {
    "simulated": dict.fromkeys((*ROLES, DIVERTER), "beltsort.cellfile.simulated:BACKEND"),
    "opcua": {
        **dict.fromkeys(("belt", "sorter"), "beltsort.cellfile.backends:OPCUA"),
        DIVERTER: "beltsort.cellfile.backends:OPCUA_DIVERTER",
    },
    "modbus": {
        **dict.fromkeys(("belt", "sorter"), "beltsort.cellfile.backends:MODBUS"),
        DIVERTER: "beltsort.cellfile.backends:MODBUS_DIVERTER",
    },
    "ros1": {role: f"beltsort.cellfile.backends:ROS1_{role.upper()}" for role in ROLES},
    "ros2": {role: f"beltsort.cellfile.backends:ROS2_{role.upper()}" for role in (*ROLES, DIVERTER)},
    "replay": dict.fromkeys(("arm", "camera", "belt"), "beltsort.cellfile.backends:REPLAY"),
    "dry-run": {role: f"beltsort.cellfile.dry_run:{role.upper()}" for role in (*ROLES, DIVERTER)},
}
"""The object of each built-in back-end, by its name and the role of the device."""


@dataclass(frozen=True)
class Backend:
    """A factory of devices of one kind.

    Attributes
    ----------
    make
        Function of the options in the cell file and the cell that returns a device: an `Arm`, a
        `DepthCamera`, a `Belt`, a `Sorter`, a `DivertingBelt`, or an object that is several of them.
    shared
        Whether one device serves all roles that name this back-end with the same options.
    harmless
        Whether the device moves no hardware, and so needs no `--live`.
    absent
        Whether the device is a placeholder: with an absent arm, the camera does not move.
    numbered
        Whether a sorter or diverter gets the numbers of the cell file's `bins`; otherwise it gets the bin's
        index among the model's, the reject bin last.
    """

    make: Callable[[Mapping[str, object], "CellDescription"], Any]
    shared: bool = False
    harmless: bool = False
    absent: bool = False
    numbered: bool = True


def backend_of(
    options: type[Options],
    make: Callable[[Options, "CellDescription"], Any],
    *,
    shared: bool = False,
    harmless: bool = False,
    absent: bool = False,
    numbered: bool = True,
) -> Backend:
    """Return a back-end whose options are a frozen dataclass of plain fields.

    Parameters
    ----------
    options
        The dataclass; options in the cell file are validated against its fields and their types.
    make
        Function of the options and the cell that returns a device.
    shared, harmless, absent, numbered
        As in `Backend`.
    """

    def made(given: Mapping[str, object], cell: "CellDescription") -> Any:
        return make(validated(options, given), cell)

    return Backend(made, shared, harmless, absent, numbered)


def backend(role: str, name: str) -> Backend:
    """Return the back-end of a device.

    Parameters
    ----------
    role
        One of `beltsort.cellfile.roles`.
    name
        Name in the cell file.

    Raises
    ------
    CellFileError
        If the name is unknown or the back-end cannot be loaded.
    """
    group = GROUP + role
    known = {name: EntryPoint(name, paths[role], group) for name, paths in BUILT_IN.items() if role in paths}
    known |= {entry.name: entry for entry in entry_points(group=group) if entry.name not in known}
    where = f"{TABLES[role]}.backend"
    if name not in known:
        what = "cannot divert objects" if role == DIVERTER else "is not a back-end of this device"
        raise CellFileError.of(where, f"is {name!r}, which {what}; {nearest_of(name, list(known))}")
    try:
        found = known[name].load()
    except (ImportError, AttributeError) as reason:
        raise CellFileError.of(
            where, f"is {name!r}, which cannot be loaded: {reason}; install what it needs"
        ) from reason
    if not isinstance(found, Backend):
        raise CellFileError.of(
            where,
            f"is {name!r}, whose entry point is {found!r}, expected a Backend: correct the package that "
            "provides it",
        )
    return found
