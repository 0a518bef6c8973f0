"""The package rerun, which is imported when a recording begins."""

from types import ModuleType

from beltsort.util.extras import extra


def load_rerun() -> ModuleType:
    """Return the package.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    with extra("rerun"):
        import rerun
        import rerun.blueprint  # not imported by the package itself
    return rerun
