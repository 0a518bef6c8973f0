"""The rules of the loop, and what they count."""

from dataclasses import dataclass, field

from beltsort._core import DEFAULT_MAX_LOOKS, MAX_IMPOSSIBLE_LABELS


@dataclass(frozen=True)
class Rules:
    """What keeps the loop from hanging.

    Attributes
    ----------
    max_looks
        An object scanned this often is decided as its most likely class, or goes to the cell's `reject_bin`.
        With poor tables and a large penalty, looking for ever would be optimal.
    empty_looks
        A position seen empty in so many scans in a row, each from another viewpoint as far as there are, is
        empty. A model with a class for empty cups does without this rule.
    impossible_labels
        So many labels in a row that the belief holds impossible are treated like `max_looks`.
    scan_attempts
        Unusable scans in a row after which the camera is taken to be broken.
    retry_delays
        Seconds before a command that failed is sent again, or a device that cannot be reached asked again,
        longer each time; when all are used up, the run is held. In all less than the commands' timeouts.
    arrival_angle, arrival_distance
        A scan taken more than so many degrees or millimetres from the viewpoint's pose, where both poses are
        known, is of another viewpoint. The arm is sent there once more; then the run is held. More than the
        errors of arm and taught poses, less than what lies between two viewpoints.
    """

    max_looks: int = DEFAULT_MAX_LOOKS
    empty_looks: int = 2
    impossible_labels: int = MAX_IMPOSSIBLE_LABELS
    scan_attempts: int = 3
    retry_delays: tuple[float, ...] = (0.2, 1.0, 5.0, 15.0)
    arrival_angle: float = 5.0
    arrival_distance: float = 50.0


@dataclass(frozen=True)
class Drift:
    """How the loop watches whether labels still come as the tables say.

    Attributes
    ----------
    false_alarm
        Probability, at most, that the watch ever raises an alarm while the model is right: see
        `beltsort.tables.DriftWatch`.
    hold
        Whether an alarm holds the run; otherwise it is only journalled.

    Raises
    ------
    ArgumentError
        If `false_alarm` is not between 0 and 1.
    """

    false_alarm: float = 0.01
    hold: bool = False

    def __post_init__(self) -> None:
        """Refuse what is no probability of an alarm."""
        from beltsort.tables.drift import check_false_alarm

        check_false_alarm(self.false_alarm)


@dataclass
class Seen:
    """What is known of one object besides the belief.

    Attributes
    ----------
    looks
        Scans in which it was visible.
    empty
        Viewpoints of the last scans in a row that saw it empty.
    impossible
        Labels in a row that the belief held impossible.
    """

    looks: int = 0
    empty: list[int] = field(default_factory=list)
    impossible: int = 0

    def known_empty(self, rules: Rules, reachable: list[int]) -> bool:
        """Whether it was seen empty often enough, and from enough viewpoints as far as there are."""
        untried = set(reachable) - set(self.empty)
        enough = rules.empty_looks
        return len(self.empty) >= enough and (len(set(self.empty)) >= enough or not untried)
