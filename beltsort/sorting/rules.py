"""The rules of the loop, and the counts that they limit."""

from dataclasses import dataclass, field

from beltsort._core import DEFAULT_MAX_LOOKS, MAX_IMPOSSIBLE_LABELS
from beltsort.util.defaults import FALSE_ALARM
from beltsort.util.naming import suggests_keywords


@suggests_keywords
@dataclass(frozen=True)
class Rules:
    """Limits of the loop, which keep it from running for ever, and of what a run keeps.

    Attributes
    ----------
    max_looks
        Number of scans after which an object goes to the bin with the largest expected reward, or to the
        cell's `reject_bin`. With poor tables and a large penalty, looking for ever would be optimal.
    empty_looks
        Number of scans in a row, from different viewpoints if there are as many, after which a position seen
        empty is taken to be empty. It does not apply if the model has a class for empty cups.
    impossible_labels
        Number of labels in a row that are impossible under the belief, after which an object is treated as
        after `max_looks`.
    scan_attempts
        Number of unusable scans in a row after which the run is held.
    retry_delays
        Delays, seconds, before each retry of a command that failed or of a device that cannot be reached;
        after the last one the run is held. Their sum should be less than the commands' timeouts.
    arrival_angle, arrival_distance
        Largest deviation, degrees and millimetres, of a scan's camera pose from the viewpoint's, if both are
        known. After a larger one the arm is sent there again; after a second one the run is held. Choose more
        than the errors of arm and taught poses, and less than the difference between two viewpoints.
    kept_scans
        Number of scans, the latest, that stay in the run's folder for `beltsort watch`, thinned out to about
        20 kB each; 0 for none.
    """

    max_looks: int = DEFAULT_MAX_LOOKS
    empty_looks: int = 2
    impossible_labels: int = MAX_IMPOSSIBLE_LABELS
    scan_attempts: int = 3
    retry_delays: tuple[float, ...] = (0.2, 1.0, 5.0, 15.0)
    arrival_angle: float = 5.0
    arrival_distance: float = 50.0
    kept_scans: int = 1000


FORCED = {
    "max_looks": "it has had as many looks as max_looks allows",
    "impossible_labels": "its last labels were impossible under the belief",
}
"""Why a rule decides about an object in the policy's place, by the name of the rule."""


def forced_in_words(rule: str) -> str:
    """Return why a rule decided about an object.

    Examples
    --------
    >>> forced_in_words("max_looks")
    'it has had as many looks as max_looks allows'
    """
    return FORCED.get(rule, rule)


@suggests_keywords
@dataclass(frozen=True)
class Drift:
    """Settings of drift detection: the test whether labels still follow the tables.

    Attributes
    ----------
    false_alarm
        Upper bound of the probability that an alarm is ever raised while the model is right: see
        `beltsort.tables.DriftWatch`.
    hold
        Whether an alarm holds the run; otherwise it is only journalled.

    Raises
    ------
    ArgumentError
        If `false_alarm` is not between 0 and 1.
    """

    false_alarm: float = FALSE_ALARM
    hold: bool = False

    def __post_init__(self) -> None:
        """Check the probability."""
        from beltsort.tables.drift import check_false_alarm

        check_false_alarm(self.false_alarm)


@dataclass
class Seen:
    """What is known about one object besides the belief.

    Attributes
    ----------
    looks
        Number of scans in which it was visible.
    empty
        Viewpoints of the latest scans in a row that saw its position empty.
    impossible
        Number of labels in a row that were impossible under the belief.
    """

    looks: int = 0
    empty: list[int] = field(default_factory=list)
    impossible: int = 0

    def known_empty(self, rules: Rules, reachable: list[int]) -> bool:
        """Whether the position was seen empty often enough, from enough of the reachable viewpoints."""
        untried = set(reachable) - set(self.empty)
        enough = rules.empty_looks
        return len(self.empty) >= enough and (len(set(self.empty)) >= enough or not untried)
