"""Packages of the extras (`pip install 'beltsort[...]'`), which an installation may lack."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from beltsort.errors import MissingExtraError

WRONG = 2  # exit code


@contextmanager
def extra(name: str, *, program: bool = False) -> Iterator[None]:
    """Turn a failed import into an error that names the extra to install.

    Of nested blocks the outermost one names the extra, since it knows best what is wanted.

    Parameters
    ----------
    name
        The extra that provides what is imported within the block.
    program
        Whether the importing module is run by `python -m`, outside of the command line's error handling:
        print the error and exit.

    Raises
    ------
    MissingExtraError
        If an import within the block fails.

    Examples
    --------
    >>> with extra("perception"):
    ...     import no_such_package
    Traceback (most recent call last):
    ...
    beltsort.errors.MissingExtraError: no_such_package is not installed; pip install 'beltsort[perception]'
    """
    try:
        yield
    except ImportError as reason:
        error = MissingExtraError(_message(name, reason))
        if not program:
            raise error from reason
        print("error:", error, file=sys.stderr)
        sys.exit(WRONG)


def require(name: str, *packages: str) -> None:
    """Check that packages are installed which will be imported later, after minutes of work for example.

    Raises
    ------
    MissingExtraError
        If one is not.
    """
    with extra(name):
        for package in packages:
            if find_spec(package) is None:
                raise ModuleNotFoundError(f"No module named {package!r}", name=package)


def _message(name: str, reason: ImportError) -> str:
    cause = reason
    while isinstance(cause, MissingExtraError) and isinstance(cause.__cause__, ImportError):
        cause = cause.__cause__
    package = (cause.name or "a package").split(".")[0]
    if isinstance(cause, ModuleNotFoundError):
        return f"{package} is not installed; pip install 'beltsort[{name}]'"
    # A shared library of the system, for example, which pip does not install.
    return (
        f"{cause}: a package of the extra {name!r} needs a library of the system, which pip does not "
        "install; the section 'Install what you need' of README lists Open3D's for Debian"
    )
