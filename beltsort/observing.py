"""Looking: a scan that can be used, what it shows, and what that says about the objects."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Protocol

from beltsort._core import Belief, ImpossibleObservationError
from beltsort.cell import CommandError, DepthCamera, EmergencyStopError, Scan
from beltsort.errors import CellError, CloudError
from beltsort.progress import Progress
from beltsort.record import Record
from beltsort.rules import Rules

if TYPE_CHECKING:
    from beltsort.tables import DriftWatch


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


Perceive = Callable[[Scan], Sequence[PerceivedPosition]]


class Observer:
    """Takes scans and updates the belief.

    Parameters
    ----------
    camera
        Takes scans.
    perceive
        From a scan to one result per position, the belt end first.
    progress
        Of the run.
    record
        Writes an entry and applies it to `progress`.
    rules
        Limits.
    watch
        Sees every scan; its alarms are written down.
    """

    def __init__(
        self,
        camera: DepthCamera,
        perceive: Perceive,
        progress: Progress,
        record: Record,
        rules: Rules,
        watch: "DriftWatch | None" = None,
    ) -> None:
        self._camera, self._perceive, self._progress, self._record = camera, perceive, progress, record
        self._rules, self._watch = rules, watch
        empty = progress.model.empty
        self._empty = None if empty is None else progress.model.classes.index(empty)

    def observe(self) -> None:
        """Scan from where the camera stands, perceive, and take in what was seen.

        A label that the belief holds impossible is dropped, and told.

        Raises
        ------
        CellError
            If `Rules.scan_attempts` scans in a row are unusable.
        EmergencyStopError
            If the emergency stop is pressed.
        """
        perceived = self._usable()
        belief, viewpoint = self._progress.belief.copy(), self._progress.viewpoint
        probabilities = belief.label_probabilities(viewpoint)
        labels = [self._label_of(what) for what in perceived]
        alarms = [] if self._watch is None else self._watch.observe(belief, viewpoint, labels)
        dropped = [
            {"position": position, "label": label, "probability": float(probabilities[position, label])}
            for position, label in enumerate(labels)
            if label is not None and not _taken_in(belief, viewpoint, position, label)
        ]
        self._record(
            "scan",
            viewpoint=viewpoint,
            labels=labels,
            empty=[what.empty for what in perceived],
            findings=[what.finding for what in perceived],
            dropped=dropped,
            belief=belief.probabilities.tolist(),
            last_labels=belief.last_labels.tolist(),
        )
        for alarm in alarms:
            self._record("drift", **alarm.to_dict())

    def _usable(self) -> Sequence[PerceivedPosition]:
        """Take a scan that perception can use."""
        for _ in range(self._rules.scan_attempts):
            try:
                return self._perceive(self._fresh_scan())
            except EmergencyStopError:
                raise
            except (CloudError, CommandError) as reason:
                self._record("bad_scan", error=str(reason))
        raise CellError(
            f"{self._rules.scan_attempts} scans in a row are unusable, expected a point cloud; check the "
            "camera (`beltsort show` tells what each lacked), then resume"
        )

    def _fresh_scan(self) -> Scan:
        """Return a scan younger than the last stop, whatever the camera thinks of that."""
        stopped = self._progress.stopped
        scan = self._camera.scan(not_before=stopped)
        if scan.stamp < stopped:
            raise CloudError(
                f"the scan is of {scan.stamp:.3f} s, before the stop at {stopped:.3f} s; set the clocks"
            )
        return scan

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
