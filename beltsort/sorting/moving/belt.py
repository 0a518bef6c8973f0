"""What the loop knows of the moving belt: how far it has come, and where objects stand on it."""

from beltsort.cell.diverting import BeltReading, DivertingBelt
from beltsort.errors import TrackingError
from beltsort.sorting.holds import HeldError, Hold
from beltsort.sorting.moving.record import Patience
from beltsort.tracking import BeltMotion, EncoderReading, Tracker, TrackerConfig


class BeltWatch:
    """Reads the belt's encoder, from which the tracks of objects follow.

    After a restart of the controller the travel begins at 0, and so do motion and tracks.

    Parameters
    ----------
    belt
        The belt.
    patience
        Asks it again while it cannot be reached.
    spacing
        Distance between two objects, metres: tracks end half of it beyond the belt end.
    """

    def __init__(self, belt: DivertingBelt, patience: Patience, spacing: float) -> None:
        self._belt, self._patience = belt, patience
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
            If the belt cannot be asked, or its encoder jumped.
        EmergencyStopError
            If the emergency stop is pressed and the belt refuses to answer.
        """
        reading = self._patience(self._belt.reading)
        if reading.boot_id != self._boot_id:
            self._begin(reading.boot_id)
        # Readings too near in time for their clock give no speed.
        newest = self._newest
        if newest is None or reading.stamp - newest.stamp > reading.error + newest.error:
            try:
                self.motion.add(EncoderReading(reading.stamp, reading.travel))
            except TrackingError as jump:
                self._begin(reading.boot_id)
                raise HeldError(Hold(None, str(jump), person=True)) from jump
            self._newest = reading
        return reading
