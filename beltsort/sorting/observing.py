"""Looking: a scan that can be used, what it shows, and what that says about the objects."""

from collections.abc import Callable, Sequence
from typing import Protocol

from beltsort._core import Belief, ImpossibleObservationError
from beltsort.cell import Cell, CommandError, EmergencyStopError, Scan
from beltsort.cell.arrival import Deviation, deviation_from, viewpoint_poses
from beltsort.errors import CloudError
from beltsort.sorting.entries import ScanElsewhere, Scanned, ScanUnusable
from beltsort.sorting.holds import HeldError, Hold
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import Record
from beltsort.sorting.rules import Rules


class PerceivedPosition(Protocol):
    """What the loop needs to know of one belt position after a scan."""

    @property
    def label(self) -> int | None:
        """Class index, or None if what was seen got no label."""

    @property
    def empty(self) -> bool:
        """Whether nothing was seen there."""

    @property
    def finding(self) -> str:
        """What was found there, or why nothing was, in a word or two."""


STRAYS = 1
"""Moves in a row that may end at another viewpoint before the run is held."""

Perceive = Callable[[Scan], Sequence[PerceivedPosition]]


class Observer:
    """Takes scans and updates the belief.

    Parameters
    ----------
    cell
        Its camera takes scans.
    perceive
        From a scan to one result per position, the belt end first.
    progress
        Of the run.
    record
        Writes an entry and applies it to `progress`.
    rules
        Limits.
    """

    def __init__(
        self,
        cell: Cell,
        perceive: Perceive,
        progress: Progress,
        record: Record,
        rules: Rules,
    ) -> None:
        self._camera, self._poses = cell.camera, viewpoint_poses(cell)
        self._perceive, self._progress, self._record = perceive, progress, record
        self._rules = rules
        empty = progress.model.empty
        self._empty = None if empty is None else progress.model.classes.index(empty)

    def observe(self) -> None:
        """Scan from where the camera stands, perceive, and take in what was seen.

        A label that the belief holds impossible is dropped, and told. So is a scan from another viewpoint
        than the arm was sent to: the camera has not arrived then.

        Raises
        ------
        CellError
            If `Rules.scan_attempts` scans in a row are unusable, or the camera stands elsewhere again.
        EmergencyStopError
            If the emergency stop is pressed.
        """
        perceived = self._usable()
        if perceived is not None:
            self._take_in(perceived)

    def _take_in(self, perceived: Sequence[PerceivedPosition]) -> None:
        """Update the belief by what was seen."""
        belief, viewpoint = self._progress.belief.copy(), self._progress.viewpoint
        probabilities = belief.label_probabilities(viewpoint)
        labels = [self._label_of(what) for what in perceived]
        dropped = [
            {"position": position, "label": label, "probability": float(probabilities[position, label])}
            for position, label in enumerate(labels)
            if label is not None and not _taken_in(belief, viewpoint, position, label)
        ]
        self._record(
            Scanned(
                viewpoint=viewpoint,
                labels=labels,
                empty=[what.empty for what in perceived],
                findings=[what.finding for what in perceived],
                dropped=dropped,
                belief=belief.probabilities.tolist(),
                last_labels=belief.last_labels.tolist(),
            )
        )

    def _usable(self) -> Sequence[PerceivedPosition] | None:
        """Take a scan that perception can use; return None if the camera stands elsewhere."""
        for _ in range(self._rules.scan_attempts):
            try:
                scan = self._fresh_scan()
                return None if self._strayed(scan) else self._perceive(scan)
            except EmergencyStopError:
                raise
            except (CloudError, CommandError) as failure:
                self._record(ScanUnusable(str(failure)))
        reason = (
            f"{self._rules.scan_attempts} scans in a row are unusable, expected a point cloud; check the "
            "camera (`beltsort show` tells what each lacked)"
        )
        raise HeldError(Hold(None, reason))

    def _fresh_scan(self) -> Scan:
        """Return a scan younger than the last stop, whatever the camera thinks of that."""
        stopped = self._progress.stopped
        scan = self._camera.scan(not_before=stopped)
        if scan.stamp < stopped:
            raise CloudError(
                f"the scan is of {scan.stamp:.3f} s, before the stop at {stopped:.3f} s; set the clocks"
            )
        return scan

    def _strayed(self, scan: Scan) -> bool:
        """Whether a scan was taken elsewhere; that is written down, and beyond `STRAYS` an error."""
        viewpoint = self._progress.viewpoint
        off = deviation_from(self._poses[viewpoint], scan)
        if off is None or not self._beyond(off):
            return False
        stands_at = self._viewpoint_of(scan)
        self._record(ScanElsewhere(viewpoint, stands_at, off.angle, off.distance))
        if self._progress.strays > STRAYS:
            raise HeldError(Hold(None, self._elsewhere(off, stands_at), person=True))
        return True

    def _beyond(self, off: Deviation) -> bool:
        return off.exceeds(self._rules.arrival_angle, self._rules.arrival_distance)

    def _viewpoint_of(self, scan: Scan) -> int | None:
        """Return the viewpoint at which a scan was taken, or None if it was taken at none."""
        deviations = [deviation_from(pose, scan) for pose in self._poses]
        found = (n for n, off in enumerate(deviations) if off is not None and not self._beyond(off))
        return next(found, None)

    def _elsewhere(self, off: Deviation, stands_at: int | None) -> str:
        names, rules = self._progress.model.viewpoints, self._rules
        where = "at no viewpoint" if stands_at is None else f"at {names[stands_at]}"
        return (
            f"the camera stands {where}, {off.angle:.1f} degrees and {off.distance:.0f} mm from "
            f"{names[self._progress.viewpoint]}, where the arm says it is, expected at most "
            f"{rules.arrival_angle:g} (rules.arrival_angle) and {rules.arrival_distance:g} "
            f"(rules.arrival_distance), and it was sent there {self._progress.strays} times; see to the arm "
            "and the viewpoint's pose (`beltsort check`)"
        )

    def _label_of(self, what: PerceivedPosition) -> int | None:
        """Return the label of one position; the model may have a class for empty cups."""
        return self._empty if what.empty and self._empty is not None else what.label


def _taken_in(belief: Belief, viewpoint: int, position: int, label: int) -> bool:
    """Update the belief about one position, unless it holds the label impossible."""
    labels: list[int | None] = [None] * len(belief.probabilities)
    labels[position] = label
    try:
        belief.observe(viewpoint, labels)
    except ImpossibleObservationError:
        return False
    return True
