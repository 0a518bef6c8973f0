"""What the loop knows of the moving belt: how far it has come, and where objects stand on it."""

from beltsort.cell.diverting import BeltReading, DivertingBelt
from beltsort.errors import TrackingError
from beltsort.sorting.holds import HeldError, Hold
from beltsort.sorting.moving.entries import EncoderJumped
from beltsort.sorting.moving.record import MovingRecord, Patience
from beltsort.tracking import BeltMotion, EncoderReading, Tracker, TrackerConfig

JUMPED = (
    "the belt's encoder jumped, and its controller still has diversions of objects that are elsewhere now; "
    "restart the controller, then resume"
)


class BeltWatch:
    """Reads the belt's encoder, from which the tracks of objects follow.

    After a restart of the controller the travel begins at 0, and so do motion and tracks. If the encoder
    jumps without one, objects are not where their coordinates say, and the controller would carry out its
    queued diversions at others: the run goes on only when it was restarted.

    Parameters
    ----------
    belt
        The belt.
    patience
        Asks it again while it cannot be reached.
    record
        Writes entries; its state says what was last known of the belt.
    spacing
        Distance between two objects, metres: tracks end half of it beyond the belt end.
    """

    def __init__(self, belt: DivertingBelt, patience: Patience, record: MovingRecord, spacing: float) -> None:
        self._belt, self._patience, self._record, self._spacing = belt, patience, record, spacing
        self._config = TrackerConfig(gate=min(0.05, spacing / 4.0), exit=-spacing / 2.0)
        self._boot_id = ""
        self._begin("")

    def _begin(self, boot_id: str) -> None:
        self.motion = BeltMotion()
        self.tracker = Tracker(self.motion, self._config)
        self._boot_id = boot_id
        self._newest: BeltReading | None = None

    def read(self) -> BeltReading:
        """Return a new reading, which is added to the belt's motion.

        Raises
        ------
        HeldError
            If the belt cannot be asked, or its encoder jumped and the controller was not restarted since.
        EmergencyStopError
            If the emergency stop is pressed and the belt refuses to answer.
        """
        reading = self._patience(self._belt.reading)
        if reading.boot_id != self._boot_id:
            self._begin(reading.boot_id)
            self._check_went_on(reading)
        if reading.boot_id == self._record.state.jumped:
            raise HeldError(Hold(None, JUMPED, person=True))
        # Readings too near in time for their clock give no speed.
        newest = self._newest
        if newest is None or reading.stamp - newest.stamp > reading.error + newest.error:
            try:
                self.motion.add(EncoderReading(reading.stamp, reading.travel))
            except TrackingError as jump:
                self._begin(reading.boot_id)
                self._record(EncoderJumped(reading.boot_id, str(jump)))
                raise HeldError(Hold(None, f"{jump}; {JUMPED}", person=True)) from jump
            self._newest = reading
        return reading

    def _check_went_on(self, reading: BeltReading) -> None:
        """Journal a jump of the encoder if the belt is not as far as the journal says it was."""
        state = self._record.state
        if state.lattice is None or reading.boot_id != state.boot_id or reading.boot_id == state.jumped:
            return
        if state.lattice.at_exit(reading.travel + self._spacing / 4.0) < state.watched_exit:
            exit_now = state.lattice.at_exit(reading.travel)
            reason = (
                f"the travel is {reading.travel:.3f} m, with which object {exit_now} is at the exit, and "
                f"object {state.watched_exit} was there already"
            )
            self._record(EncoderJumped(reading.boot_id, reason))
