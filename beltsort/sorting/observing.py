"""Taking scans: a usable scan is perceived, and the belief updated with its labels."""

from collections.abc import Sequence

from beltsort._core import Belief, ImpossibleObservationError
from beltsort.cell import Cell, CommandError, EmergencyStopError, Scan
from beltsort.cell.arrival import deviation_from, viewpoint_poses
from beltsort.errors import CloudError
from beltsort.sorting.entries import ScanElsewhere, Scanned, ScanUnusable, Unheard
from beltsort.sorting.entry_format import plain_belief
from beltsort.sorting.holds import HeldError, Hold
from beltsort.sorting.journal import Entry
from beltsort.sorting.kept_scans import ScanListener
from beltsort.sorting.perceived import LabelNumbers, Perceive, PerceivedPosition, pose_fault_of
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import Record
from beltsort.sorting.rules import Rules

MISSED_ARRIVALS = 1
"""Moves in a row that may end away from their viewpoint before the run is held."""


class Observer:
    """Takes scans and updates the belief.

    Parameters
    ----------
    cell
        The cell; its camera takes the scans.
    perceive
        Function from a scan to one result per position.
    progress
        State of the run.
    record
        Writes an entry and applies it to `progress`.
    rules
        Limits.
    listener
        Called with every scan that was used; one that fails is journalled and not called again.

    Raises
    ------
    CellError
        If the labels of perception are not the model's.
    """

    def __init__(
        self,
        cell: Cell,
        perceive: Perceive,
        progress: Progress,
        record: Record,
        rules: Rules,
        listener: ScanListener | None = None,
    ) -> None:
        self._camera, self._poses = cell.camera, viewpoint_poses(cell)
        self._perceive, self._progress, self._record = perceive, progress, record
        self._rules, self._listener = rules, listener
        self._labels = LabelNumbers(perceive, progress.model)

    def observe(self) -> None:
        """Scan from the current viewpoint, perceive, and update the belief.

        A label that is impossible under the belief is dropped, and journalled as such. So is a scan that was
        not taken from the viewpoint that the arm was sent to; the camera then counts as not arrived.

        Raises
        ------
        HeldError
            If `Rules.scan_attempts` scans in a row are unusable, or the camera misses its viewpoint again.
        EmergencyStopError
            If the emergency stop is pressed.
        """
        for _ in range(self._rules.scan_attempts):
            try:
                scan = self._fresh_scan()
                if self._taken_elsewhere(scan):
                    return
                perceived = self._perceive(scan)
            except EmergencyStopError:
                raise
            except (CloudError, CommandError) as failure:
                self._record(ScanUnusable(str(failure)))
            else:
                self._notify(self._update(perceived), scan, perceived)
                return
        reason = (
            f"{self._rules.scan_attempts} scans in a row are unusable, expected a point cloud; check the "
            "camera (`beltsort show` tells what each lacked)"
        )
        raise HeldError(Hold(None, reason))

    def _fresh_scan(self) -> Scan:
        """Return a scan taken after the last stop; the camera's own check of that is not relied on."""
        stopped = self._progress.stopped
        scan = self._camera.scan(not_before=stopped)
        if scan.stamp < stopped:
            raise CloudError(
                f"the scan is of {scan.stamp:.3f} s, before the stop at {stopped:.3f} s; set the clocks"
            )
        return scan

    def _notify(self, entry: Entry, scan: Scan, perceived: Sequence[PerceivedPosition]) -> None:
        """Call the listener; the run continues if it fails."""
        if self._listener is None:
            return
        try:
            self._listener(entry, scan, perceived)
        except Exception as failure:  # any exception; the run continues
            self._listener = None
            self._record(Unheard(repr(failure)))

    def _update(self, perceived: Sequence[PerceivedPosition]) -> Entry:
        """Update the belief with the labels of a scan, journal them, and return the entry.

        If the model has a class for empty cups and a label of its name, an empty position gets this label.
        """
        belief, viewpoint = self._progress.belief.copy(), self._progress.viewpoint
        probabilities = belief.label_probabilities(viewpoint)
        labels = [self._labels.of(seen) for seen in perceived]
        dropped = [
            {"position": position, "label": label, "probability": float(probabilities[position, label])}
            for position, label in enumerate(labels)
            if label is not None and not _possible(belief, viewpoint, position, label)
        ]
        return self._record(
            Scanned(
                viewpoint=viewpoint,
                labels=labels,
                empty=[seen.empty for seen in perceived],
                findings=[seen.finding for seen in perceived],
                dropped=dropped,
                pose_fault=pose_fault_of(perceived),
                **plain_belief(belief),
            )
        )

    def _taken_elsewhere(self, scan: Scan) -> bool:
        """Whether a scan was taken from elsewhere; more than `MISSED_ARRIVALS` in a row hold the run."""
        viewpoint, rules = self._progress.viewpoint, self._rules
        limits = rules.arrival_angle, rules.arrival_distance
        off = deviation_from(self._poses[viewpoint], scan)
        if off is None or not off.exceeds(*limits):
            return False
        others = ((n, deviation_from(pose, scan)) for n, pose in enumerate(self._poses))
        stands_at = next((n for n, other in others if other is not None and not other.exceeds(*limits)), None)
        self._record(ScanElsewhere(viewpoint, stands_at, off.angle, off.distance))
        if self._progress.missed_arrivals > MISSED_ARRIVALS:
            names = self._progress.model.viewpoints
            where = "at no viewpoint" if stands_at is None else f"at {names[stands_at]}"
            reason = (
                f"the camera stands {where}, {off.angle:.1f} degrees and {off.distance:.0f} mm from "
                f"{names[viewpoint]}, where the arm says it is, expected at most {rules.arrival_angle:g} "
                f"(rules.arrival_angle) and {rules.arrival_distance:g} (rules.arrival_distance), and it was "
                f"sent there {self._progress.missed_arrivals} times; see to the arm and the viewpoint's pose "
                "(`beltsort check`)"
            )
            raise HeldError(Hold(None, reason, person=True))
        return True


def _possible(belief: Belief, viewpoint: int, position: int, label: int) -> bool:
    """Update the belief about one position; return whether the label is possible, else change nothing."""
    labels: list[int | None] = [None] * len(belief.probabilities)
    labels[position] = label
    try:
        belief.observe(viewpoint, labels)
    except ImpossibleObservationError:
        return False
    return True
