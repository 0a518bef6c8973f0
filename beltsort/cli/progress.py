"""How far a long task has come, on standard error."""

from typing import TYPE_CHECKING

from beltsort.cli.output import tell

if TYPE_CHECKING:
    from beltsort.tables.processes import Progress


def tenths(what: str) -> "Progress":
    """Return what tells every tenth of `what`."""

    def report(done: int, total: int) -> None:
        if done * 10 // total > (done - 1) * 10 // total:
            tell(f"{what} {100 * done // total} %")

    return report
