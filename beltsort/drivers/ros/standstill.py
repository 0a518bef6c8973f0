"""Detection of the end of a motion from joint states."""

from enum import Enum

from beltsort.drivers.ros.joints import Joints, distance

JITTER = 0.25
"""Largest apparent motion of joints that stand still, as a fraction of the tolerance."""


class Motion(Enum):
    """The state of a motion."""

    MOVING = "moving"
    """Moving, or not standing still for long enough yet."""
    ARRIVED = "arrived"
    """Standing still at the target."""
    ELSEWHERE = "elsewhere"
    """Standing still, and not at the target."""


class Standstill:
    """Detects from joint states whether an arm has arrived, or has stopped elsewhere.

    Parameters
    ----------
    target
        Target positions of the joints, radians.
    tolerance
        Largest deviation of a joint from its target, radians.
    still
        Time for which the joints must stand still at the target to have arrived, seconds.
    stalled
        Time for which they must stand still elsewhere to have stopped there, seconds. After a gap of more
        than half of it between joint states, the time starts again.

    Examples
    --------
    >>> watch = Standstill({"elbow": 1.0}, tolerance=0.02, still=0.2, stalled=2.0)
    >>> [watch.see(time, {"elbow": 0.99}).value for time in (5.0, 5.1, 5.2)]
    ['moving', 'moving', 'arrived']
    >>> [watch.see(time, {"elbow": 0.5}).value for time in (6.0, 6.9, 9.0, 9.9, 10.8, 11.0)]
    ['moving', 'moving', 'moving', 'moving', 'moving', 'elsewhere']
    """

    def __init__(self, target: Joints, *, tolerance: float, still: float, stalled: float) -> None:
        self._target, self._tolerance = target, tolerance
        self._still, self._stalled = still, stalled
        self._silence = stalled / 2
        self._since: tuple[float, Joints] | None = None
        self._last = float("-inf")

    def see(self, stamp: float, joints: Joints) -> Motion:
        """Add the joint positions at a time (seconds), not older than the last one; return the state."""
        jitter = JITTER * self._tolerance
        unseen = stamp - self._last > self._silence
        if self._since is None or unseen or distance(self._own(self._since[1]), joints) > jitter:
            self._since = stamp, joints
        self._last = stamp
        standing = stamp - self._since[0]
        if distance(self._target, joints) <= self._tolerance:
            return Motion.ARRIVED if standing >= self._still else Motion.MOVING
        return Motion.ELSEWHERE if standing >= self._stalled else Motion.MOVING

    def expect_no_more(self) -> None:
        """Note that the motion has ended, so that a short standstill elsewhere is final."""
        self._stalled = self._still

    def _own(self, joints: Joints) -> Joints:
        return {name: joints[name] for name in self._target}
