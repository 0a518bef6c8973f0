"""Diversions: each object's decision is sent once, and its end is told.

| the controller says | before the object is at the exit | after it |
|---|---|---|
| queued | nothing is to be done | it is asked again until it says something else |
| done, too late, not done | noted | the object has left: in the bin, or in the overflow |
| refused, and not remembered | sent again under its id | the object has left, in the overflow |
| unknown | - | the object has left, in the bin or in the overflow |

The controller executes an id at most once: a diversion may be sent again while its state is not known.
"""

import logging
from functools import partial

from beltsort.cell import CommandError, EmergencyStopError, Outcome
from beltsort.cell.bins import bin_of
from beltsort.cell.diverting import Diversion, DiversionStatus, DivertingCell, KnowsClassesAt
from beltsort.planning.decisions import class_probabilities, right_bins
from beltsort.sorting.moving.entries import BeltObject, DiversionTold, Diverting, Fate, FoundEmpty, ObjectLeft
from beltsort.sorting.moving.record import MovingRecord, Patience
from beltsort.sorting.moving.state import final_fate

log = logging.getLogger(__name__)

ASKED_AT_ONCE = 4
"""Number of diversions whose outcome is asked in one step of the loop."""


class Diverter:
    """Sends diversions and follows them to their end.

    Parameters
    ----------
    cell
        The cell, whose belt carries them out.
    record
        Writes entries and applies them to the run's state.
    patience
        Asks the belt again while it cannot be reached.
    """

    def __init__(self, cell: DivertingCell, record: MovingRecord, patience: Patience) -> None:
        self._cell, self._record, self._patience = cell, record, patience
        self._right = right_bins(record.state.belt.model)

    def decide(self, number: int, bin: int) -> None:
        """Journal the decision about an object and send its diversion; none for an empty cup.

        Raises
        ------
        EmergencyStopError
            If the emergency stop is pressed.
        """
        state, model = self._record.state, self._record.state.belt.model
        known = state.known(number)
        classes = class_probabilities(model, known.kinds)
        probability = float(sum(p for p, right in zip(classes, self._right[bin], strict=True) if right))
        if model.bins[bin] == model.empty:
            self._record(FoundEmpty(number, probability, known.looks))
            return
        assert state.lattice is not None
        coordinate = state.lattice.coordinate(number) if known.coordinate is None else known.coordinate
        true = self._cell.true_class_at(coordinate) if isinstance(self._cell, KnowsClassesAt) else None
        self._record(
            Diverting(
                command_id=f"{state.run}-divert-{state.commands + 1}",
                number=number,
                coordinate=coordinate,
                bin=bin,
                name=bin_of(self._cell, bin).name,
                boot_id=state.boot_id,
                belief=probability,
                looks=known.looks,
                true_class=true,
            )
        )
        self._send(number)

    def follow(self, at_exit: int) -> None:
        """Ask what became of diversions, send refused ones again, and tell the objects that have left.

        Parameters
        ----------
        at_exit
            Number of the object at the belt end; those before it have passed the exit.
        """
        asked = 0
        for number, known in list(self._record.state.diversions.items()):
            state = None if known.state is None else Diversion(known.state)
            if known.retry and number >= at_exit:
                self._send(number)
            elif known.retry:
                self._record(ObjectLeft(number, Fate.NOT_DONE, "refused until it had passed"))
            elif state is not None and state.final:
                if number < at_exit:
                    self._record(ObjectLeft(number, final_fate(state)))
            elif (state is not Diversion.QUEUED or number < at_exit) and asked < ASKED_AT_ONCE:
                asked += 1
                if self._ask(number, known) is Diversion.UNKNOWN and number < at_exit:
                    self._record(ObjectLeft(number, Fate.UNKNOWN, "the controller does not remember it"))

    def close(self, until: int) -> None:
        """Tell the objects up to a number whose coordinates a restart of the controller has made void."""
        state = self._record.state
        for number in sorted({*range(state.settled, until), *state.on_belt}):
            known = state.on_belt.get(number)
            if known is not None and known.skipped:
                self._record(ObjectLeft(number, Fate.EMPTY))
            elif known is None or known.command_id is None:
                self._record(ObjectLeft(number, Fate.LOST, "the belt's controller was restarted"))
            else:
                told = None if known.state is None else Diversion(known.state)
                if told is None or not told.final:
                    told = self._ask(number, known)
                self._record(ObjectLeft(number, final_fate(told), "the belt's controller was restarted"))

    def _send(self, number: int) -> None:
        """Send the diversion of an object, perhaps again, and journal what the controller says."""
        known = self._record.state.on_belt[number]
        assert known.command_id is not None
        assert known.bin is not None
        assert known.coordinate is not None
        assert self._record.state.lattice is not None
        try:
            status = self._cell.belt.divert(
                known.command_id,
                number=self._record.state.lattice.mark(number),
                coordinate=known.coordinate,
                label=known.bin,
                boot_id=self._record.state.boot_id,
            )
        except CommandError as failure:
            never = failure.outcome is Outcome.NOT_DONE
            state = Diversion.NOT_DONE if never else Diversion.UNKNOWN
            self._told(number, DiversionStatus(state, "", repr(failure), retry=never))
            if isinstance(failure, EmergencyStopError):
                raise
            return
        self._told(number, status)

    def _ask(self, number: int, known: BeltObject) -> Diversion:
        """Ask what became of a diversion, journal and return it."""
        id_, boot_id = known.command_id, self._record.state.boot_id
        assert id_ is not None
        status = self._patience(partial(self._cell.belt.diversion, id_, boot_id=boot_id))
        self._told(number, status)
        return status.state

    def _told(self, number: int, status: DiversionStatus) -> None:
        """Journal what the controller says, if it is something new."""
        known = self._record.state.on_belt[number]
        if (known.state, known.retry) != (status.state.value, status.retry):
            assert known.command_id is not None
            self._record(
                DiversionTold(known.command_id, number, status.state.value, status.reason, status.retry)
            )
        if status.state is not Diversion.QUEUED and not status.state.final:
            log.warning("object %d: the controller says %s", number, status.state.value)
