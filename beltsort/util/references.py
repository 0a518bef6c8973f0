"""Objects of Python modules by a name of the form `module:object`."""

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort._core import BeltsortError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

REFERENCE = re.compile(r"[^\W\d][\w.]*:[^\W\d][\w.]*")


def is_reference(name: str) -> bool:
    """Whether a name is of the form `module:object`.

    Examples
    --------
    >>> [is_reference(name) for name in ("nets.bulbs:CLASSIFIER", "threshold:0.94", "acme")]
    [True, False, False]
    """
    return REFERENCE.fullmatch(name) is not None


def object_of(name: str, folder: Path, what: str, error: type[BeltsortError]) -> object:
    """Return the object that `module:object` names.

    Parameters
    ----------
    name
        The name.
    folder
        Where modules are found that are not installed. It stays at the end of `sys.path`, since modules may
        import others later.
    what
        The kind of object, for the error message.
    error
        The type of the error.

    Raises
    ------
    BeltsortError
        Of the type `error`, if the module cannot be imported or has no such object.
    """
    from importlib.metadata import EntryPoint  # takes a while

    if (path := str(folder.resolve())) not in sys.path:
        sys.path.append(path)
    return loaded(EntryPoint(name, name, ""), what, error)


def loaded(entry: "EntryPoint", what: str, error: type[BeltsortError]) -> object:
    """Return the object of an entry point, or raise an `error`."""
    shown = f"the {what} {entry.name!r} cannot be loaded"
    try:
        found: object = entry.load()
    except (ImportError, AttributeError) as reason:
        raise error(
            f"{shown}: {reason}; expected module:object, both of them there: correct the name, or install "
            "what it needs"
        ) from reason
    except Exception as reason:  # whatever the module's own code raises
        raise error(
            f"{shown}: {type(reason).__name__}: {reason}; expected a module that can be imported: correct it"
        ) from reason
    return found
