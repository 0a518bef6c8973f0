"""What the classifier returned for many scans, from which any rule makes labels without another scan."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from beltsort.errors import RecordingError
from beltsort.perception.classifier import Match, Scores
from beltsort.perception.finding import Finding
from beltsort.perception.label_rule import LabelRule
from beltsort.perception.pipeline import Perceived
from beltsort.perception.pose_fault import PoseFault
from beltsort.tables.log import fault_in, plain_fault
from beltsort.tables.scans import LabelledScan
from beltsort.util.keyed_log import KeyedLog


class Seen(NamedTuple):
    """What one scan shows of one position.

    Attributes
    ----------
    match
        What the classifier returned, or None.
    finding
        What was found.
    pose_fault
        What is likely wrong with the scan's pose, or None.
    """

    match: Match | None
    finding: Finding = Finding.OBJECT
    pose_fault: PoseFault | None = None

    @classmethod
    def of(cls, perceived: Perceived) -> "Seen":
        """Return what is kept of a perceived position."""
        return cls(perceived.match, perceived.finding, perceived.pose_fault)


Matches: TypeAlias = dict[str, tuple[Seen, ...]]
"""What is seen at each position, by the scan's key."""


@dataclass(frozen=True, eq=False)
class MatchedScan:
    """What the classifier returned for one scan, with the true classes; a rule makes a `LabelledScan` of it.

    Attributes
    ----------
    viewpoint, true, objects
        As in `LabelledScan`.
    seen
        What was seen at each position.
    """

    viewpoint: int
    true: tuple[int | None, ...]
    objects: tuple[str | None, ...]
    seen: tuple[Seen, ...]

    def labelled(self, rule: LabelRule) -> LabelledScan:
        """Return the scan with the labels of a rule.

        Raises
        ------
        DatabaseError
            If the rule does not fit the classifier, see `LabelRule.label`.
        """
        return LabelledScan(
            self.viewpoint,
            self.true,
            self.objects,
            tuple(rule.label(seen.match, seen.finding) for seen in self.seen),
            tuple(seen.finding for seen in self.seen),
            self.seen[0].pose_fault if self.seen else None,
        )


class MatchLog(KeyedLog):
    """Matches by scan; see `KeyedLog`.

    Raises
    ------
    RecordingError
        If the file cannot be read or written, is no such log, or has other settings.

    Examples
    --------
    >>> log = MatchLog()
    >>> match = Match(1, np.array([0.0, 1.0]), distances=np.array([np.inf, 0.5]))
    >>> log.append({"scan 7": (Seen(match), Seen(None, Finding.EMPTY))})
    >>> first, second = log.matches()["scan 7"]
    >>> first.match.label, first.match.distances.tolist(), second
    (1, [inf, 0.5], Seen(match=None, finding=<Finding.EMPTY: 'empty'>, pose_fault=None))
    """

    table, contents = "scans", "matches"
    maker, error = "`beltsort estimate`", RecordingError

    def append(self, values: Mapping[str, Sequence[Seen]]) -> None:
        """Write what was seen durably. Keys that exist already keep their values."""
        super().append({key: [_plain(seen) for seen in positions] for key, positions in values.items()})

    def matches(self) -> Matches:
        """Return what was seen in all scans, in the order in which they were written."""
        return {key: tuple(map(_seen, positions)) for key, positions in self.values().items()}


def _plain(seen: Seen) -> dict[str, Any]:
    match = seen.match
    found = {"finding": seen.finding, **plain_fault(seen.pose_fault)}
    if match is None:
        return found
    arrays = {"scores": match.scores, "distances": match.distances, "probabilities": match.probabilities}
    return {
        **found,
        "label": match.label,
        **{name: _numbers(array) for name, array in arrays.items() if array is not None},
    }


def _numbers(array: Scores) -> list[float | None]:
    """Return plain numbers, None for infinity, which JSON does not have."""
    return [number if np.isfinite(number) else None for number in array.tolist()]


def _seen(plain: Mapping[str, Any]) -> Seen:
    finding, fault = Finding(plain["finding"]), fault_in(plain)
    if "scores" not in plain:
        return Seen(None, finding, fault)
    others = {name: _array(plain[name]) for name in ("distances", "probabilities") if name in plain}
    return Seen(Match(plain["label"], _array(plain["scores"]), **others), finding, fault)


def _array(numbers: Sequence[float | None]) -> Scores:
    return np.array([np.inf if number is None else number for number in numbers])
