"""The motion of a belt, from readings of its encoder or of its speed."""

from bisect import bisect_right
from collections import deque
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from beltsort.errors import TrackingError
from beltsort.util.naming import suggests_keywords


@dataclass(frozen=True)
class EncoderReading:
    """A reading of the belt's encoder.

    Attributes
    ----------
    stamp
        Its time, seconds on the cell's clock.
    travel
        How far the belt has moved, metres, from any zero; it increases as objects move towards the belt end.
    """

    stamp: float
    travel: float

    @classmethod
    def of_counts(cls, stamp: float, counts: int, metres_per_count: float) -> "EncoderReading":
        """Return the reading of a counter that does not wrap around.

        Parameters
        ----------
        stamp
            Seconds on the cell's clock.
        counts
            What the counter says.
        metres_per_count
            Travel of one count; negative if the counter counts down as the belt moves on.

        Examples
        --------
        >>> EncoderReading.of_counts(2.0, 1500, 0.0001)
        EncoderReading(stamp=2.0, travel=0.15)
        """
        return cls(stamp, counts * metres_per_count)


@dataclass(frozen=True)
class Travel:
    """How far the belt had moved at some time.

    Attributes
    ----------
    metres
        The travel.
    error
        Its standard deviation, metres, as far as readings and acceleration allow.
    """

    metres: float
    error: float


@suggests_keywords
@dataclass(frozen=True)
class MotionConfig:
    """What is known about a belt and its encoder.

    Attributes
    ----------
    reading_error
        Standard deviation of a reading, metres.
    most_speed
        Metres per second; a larger difference between two readings is a jump of the encoder.
    most_acceleration
        Metres per second squared; bounds what the belt does between and after readings.
    longest_gap
        Seconds after the newest reading for which the travel is extrapolated.
    memory
        Seconds before the newest reading for which readings are kept.
    """

    reading_error: float = 0.0005
    most_speed: float = 2.0
    most_acceleration: float = 1.0
    longest_gap: float = 0.2
    memory: float = 60.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name in ("reading_error", "most_speed", "most_acceleration", "longest_gap", "memory"):
            value = getattr(self, name)
            if not 0.0 <= value < np.inf:
                raise TrackingError(f"{name} is {value}, expected a finite number of at least 0: correct it")


class BeltMotion:
    """Travel of the belt at any time, from its readings.

    Between two readings the travel is linear; with an acceleration of at most a, it is then wrong by at most
    a (t - t1) (t2 - t) / 2. After the newest one it continues at the speed between the last two, which is
    wrong by at most a (t - t2) (t - t1) / 2. A third of the bound is taken for a standard deviation.

    A reading that cannot be is refused, and the motion stays as it was.

    Parameters
    ----------
    config
        What is known about belt and encoder.

    Examples
    --------
    >>> motion = BeltMotion()
    >>> motion.add(EncoderReading(0.0, 0.0))
    >>> motion.add(EncoderReading(0.1, 0.02))
    >>> round(motion.travel(0.05).metres, 6), round(motion.travel(0.15).metres, 6)
    (0.01, 0.03)
    """

    def __init__(self, config: MotionConfig | None = None) -> None:
        self.config = MotionConfig() if config is None else config
        self._readings: deque[EncoderReading] = deque()
        self._speed: tuple[float, float] | None = None  # stamp and value of the newest reading of the speed

    def add(self, reading: EncoderReading) -> None:
        """Add a reading.

        Raises
        ------
        TrackingError
            If its stamp is not after that of the newest reading, or the belt cannot have moved so far since.
        """
        if not (np.isfinite(reading.stamp) and np.isfinite(reading.travel)):
            raise TrackingError(f"the reading is {reading}, expected finite numbers: check the encoder")
        if self._readings:
            self._check_follows(reading, self._readings[-1])
        self._readings.append(reading)
        while self._too_old():
            self._readings.popleft()

    def add_speed(self, stamp: float, speed: float) -> None:
        """Add a reading of the belt's speed, for belts without an encoder of their travel.

        The travel since the newest reading is the mean of the speeds then and now times the time between.

        Parameters
        ----------
        stamp
            Seconds on the cell's clock.
        speed
            Metres per second towards the belt end.

        Raises
        ------
        TrackingError
            As `add`.
        """
        travel = 0.0
        if self._readings:
            last = self._readings[-1]
            before = speed if self._speed is None or self._speed[0] != last.stamp else self._speed[1]
            travel = last.travel + (before + speed) / 2.0 * (stamp - last.stamp)
        self.add(EncoderReading(stamp, travel))
        self._speed = (stamp, speed)

    def travel(self, stamp: float) -> Travel:
        """Return how far the belt had moved at a time, seconds on the cell's clock.

        Raises
        ------
        TrackingError
            If the readings say nothing about that time: it is before the oldest one kept, too long after the
            newest one, or there is only one.
        """
        readings = self._readings
        if not readings:
            raise TrackingError("the belt has no reading, expected some: add the encoder's first")
        first, last = readings[0], readings[-1]
        if not first.stamp <= stamp <= last.stamp + self.config.longest_gap:
            raise TrackingError(
                f"the time is {stamp:.3f} s, expected {first.stamp:.3f} (the oldest reading kept) to "
                f"{last.stamp:.3f} (the newest) plus longest_gap, {self.config.longest_gap:g} s: add "
                "readings more often, and before scans of that time"
            )
        if stamp == last.stamp:
            return Travel(last.travel, self.config.reading_error)
        if len(readings) == 1:
            raise TrackingError(
                f"the time is {stamp:.3f} s and the only reading is of {last.stamp:.3f} s, expected two or "
                "more after which to extrapolate: add another"
            )
        after = min(bisect_right(readings, stamp, key=attrgetter("stamp")), len(readings) - 1)
        return self._between(readings[after - 1], readings[after], stamp)

    def _between(self, a: EncoderReading, b: EncoderReading, stamp: float) -> Travel:
        """Return the travel on the line through two readings."""
        share = (stamp - a.stamp) / (b.stamp - a.stamp)
        bound = self.config.most_acceleration * abs((stamp - a.stamp) * (b.stamp - stamp)) / 2.0
        reading = self.config.reading_error * float(np.hypot(1.0 - share, share))
        return Travel(a.travel + share * (b.travel - a.travel), float(np.hypot(reading, bound / 3.0)))

    def _check_follows(self, reading: EncoderReading, last: EncoderReading) -> None:
        """Check that a reading can follow the newest one."""
        if reading.stamp <= last.stamp:
            raise TrackingError(
                f"the reading's stamp is {reading.stamp:.3f} s, expected after {last.stamp:.3f} s, that of "
                "the reading before: give readings in the order of their stamps, each once"
            )
        noise = 6.0 * self.config.reading_error
        moved, most = reading.travel - last.travel, self.config.most_speed * (reading.stamp - last.stamp)
        if not -noise <= moved <= most + noise:
            raise TrackingError(
                f"the belt moved by {moved:.4f} m in {reading.stamp - last.stamp:.3f} s, expected 0 to "
                f"{most:.4f} m (most_speed {self.config.most_speed:g} m/s): the encoder jumped or was reset. "
                "Nothing that was tracked is where it was expected: begin with a new BeltMotion and Tracker"
            )

    def _too_old(self) -> bool:
        """Whether the oldest reading is not needed for any time within the memory."""
        readings = self._readings
        return len(readings) > 2 and readings[1].stamp < readings[-1].stamp - self.config.memory
