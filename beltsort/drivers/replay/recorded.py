"""Wrappers around devices that record scans and stops with a `Recorder`."""

from collections.abc import Sequence

from beltsort.cell.commands import TIMEOUT, Outcome
from beltsort.cell.protocols import Arm, Belt, DepthCamera, Health, Scan
from beltsort.drivers.replay.options import OBJECTS, VIEWPOINTS
from beltsort.drivers.replay.recording import Recorder


class RecordingCamera:
    """A camera whose scans are recorded.

    Parameters
    ----------
    camera
        The camera.
    recorder
        The recorder.
    """

    def __init__(self, camera: DepthCamera, recorder: Recorder) -> None:
        self._camera, self._recorder = camera, recorder

    def health(self) -> Health:
        """Return the camera's health."""
        return self._camera.health()

    def stop(self) -> None:
        """Stop the camera."""
        self._camera.stop()

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan whose exposure began at or after `not_before`, and record it."""
        scan = self._camera.scan(not_before=not_before, timeout=timeout)
        self._recorder.scan(scan)
        return scan


class RecordingArm:
    """An arm whose stops are recorded.

    Parameters
    ----------
    arm
        The arm.
    recorder
        The recorder.
    viewpoints
        Names of the viewpoints.
    """

    def __init__(self, arm: Arm, recorder: Recorder, viewpoints: Sequence[str]) -> None:
        self._arm, self._recorder, self._viewpoints = arm, recorder, tuple(viewpoints)

    def health(self) -> Health:
        """Return the arm's health."""
        return self._arm.health()

    def stop(self) -> None:
        """Stop the arm."""
        self._arm.stop()

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command."""
        return self._arm.outcome_of(command_id)

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Move the camera to `viewpoint`; return the time at which it stopped, and record it."""
        time = self._arm.move_to(viewpoint, command_id, timeout=timeout)
        self._recorder.stopped(VIEWPOINTS, self._viewpoints[viewpoint], time)
        return time


class RecordingBelt:
    """A belt whose stops are recorded.

    Parameters
    ----------
    belt
        The belt.
    recorder
        The recorder.
    """

    def __init__(self, belt: Belt, recorder: Recorder) -> None:
        self._belt, self._recorder = belt, recorder

    def health(self) -> Health:
        """Return the belt's health."""
        return self._belt.health()

    def stop(self) -> None:
        """Stop the belt."""
        self._belt.stop()

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command."""
        return self._belt.outcome_of(command_id)

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring object `index` to the belt end; return the time at which the belt stopped, and record it."""
        time = self._belt.advance_to(index, command_id, timeout=timeout)
        self._recorder.stopped(OBJECTS, str(index), time)
        return time
