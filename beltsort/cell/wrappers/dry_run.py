"""Dry runs: commands are printed instead of executed."""

from collections.abc import Callable

from beltsort.cell.commands import Act, CommandError, Outcome
from beltsort.cell.diverting import Diversion, DiversionStatus
from beltsort.cell.wrappers.layer import (
    METHODS,
    AskDiversion,
    DiversionQuery,
    Divert,
    DivertRequest,
    Layer,
    Request,
    Send,
)

Say = Callable[[str], None]


class DryRun(Layer):
    """Prints commands instead of sending them, and reports them as done.

    Health, scans and readings of an encoder are the device's own. Since nothing moves, every scan is recent
    enough: the time of each stop is 0. A diversion is queued, and done when the belt is asked for it.

    Parameters
    ----------
    say
        Called with a line for each command.
    """

    def __init__(self, say: Say) -> None:
        self._say = say
        self._done: dict[str, Act] = {}
        self._diverted: set[str] = set()

    def command(self, _send: Send, request: Request) -> float:
        """Print a command, once for each id."""
        act, command_id = request.act, request.command_id
        if command_id not in self._done:
            self._done[command_id] = act
            self._say(f"dry run: {METHODS[type(act)]}({act.target}), {command_id}")
        if self._done[command_id] != act:
            raise CommandError(
                f"command id {command_id!r} was used for another command; give every command its own id",
                Outcome.NOT_DONE,
            )
        return 0.0

    def outcome_of(self, _ask: Callable[[str], Outcome], command_id: str) -> Outcome:
        """Return `DONE` for a command that was printed."""
        return Outcome.DONE if command_id in self._done else Outcome.NOT_DONE

    def divert(self, _send: Divert, request: DivertRequest) -> DiversionStatus:
        """Print a diversion, once for each id."""
        if request.command_id not in self._diverted:
            self._diverted.add(request.command_id)
            where = f"object {request.number} at {request.coordinate:.3f} m into bin {request.label}"
            self._say(f"dry run: divert({where}), {request.command_id}")
        return DiversionStatus(Diversion.QUEUED, request.boot_id)

    def diversion(self, _ask: AskDiversion, query: DiversionQuery) -> DiversionStatus:
        """Return `DONE` for a diversion that was printed."""
        if query.command_id in self._diverted:
            return DiversionStatus(Diversion.DONE, query.boot_id)
        return DiversionStatus(Diversion.NOT_DONE, query.boot_id, "it was not printed", retry=True)

    def stop(self, _stop: Callable[[], None]) -> None:
        """Do nothing, since nothing moves."""

    def position(self, _ask: Callable[[], int | None]) -> int | None:
        """Return None: the belt's real position is not the run's."""
        return None
