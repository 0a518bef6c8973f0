"""How far a long task has come, on standard error."""

from time import monotonic
from typing import TYPE_CHECKING

from beltsort.cli.output import tell

if TYPE_CHECKING:
    from beltsort.util.processes import Progress


def tenths(what: str) -> "Progress":
    """Return what tells every tenth of `what`."""

    def report(done: int, total: int) -> None:
        if _tenth(done, total):
            tell(f"{what} {100 * done // total} %")

    return report


def with_eta(what: str) -> "Progress":
    """Return what tells every tenth of `what`, with the time that the rest will take at the speed so far.

    The first call says how much there is from before.
    """
    began = monotonic()
    before: int | None = None

    def report(done: int, total: int) -> None:
        nonlocal before
        if before is None:
            before = done
            tell(f"{what} {done} of {total} are there")
        elif _tenth(done, total):
            left = (monotonic() - began) / (done - before) * (total - done)
            tell(f"{what} {done} of {total}, {left:.0f} s left")

    return report


def _tenth(done: int, total: int) -> bool:
    """Whether a tenth is full now that was not before."""
    return done * 10 // total > (done - 1) * 10 // total
