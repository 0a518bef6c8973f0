"""From what a classifier returns to a label: a class with a level of confidence.

A label of two levels says more than a class: "livarno, sure" is stronger evidence than "livarno, unsure", and
observation tables with a column for each tell how much stronger.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Literal, TypeAlias, get_args

import numpy as np

import beltsort
from beltsort.errors import DatabaseError
from beltsort.perception.classifier import Match
from beltsort.perception.finding import Finding
from beltsort.util.html import box, table
from beltsort.util.problems import Problem, listed

Score: TypeAlias = Literal["margin", "probability"]

LEVEL_NAMES = (
    ("",),
    ("unsure", "sure"),
    ("unsure", "fairly sure", "sure"),
    ("very unsure", "unsure", "sure", "very sure"),
)
"""Names of one, two, three and four levels, least confidence first."""

MOST_LEVELS = len(LEVEL_NAMES)
NOT_RECOGNISED, NOTHING_SEEN = "not recognised", "nothing seen"
WITHOUT_CANDIDATE = (Finding.EMPTY, Finding.HIDDEN)


@dataclass(frozen=True)
class LabelRule:
    """Cuts a score of confidence into levels; a label is a class and a level.

    The labels are numbered class by class, in a class from the least confidence to the most, then "not
    recognised", then "nothing seen". With no edges and neither of these two they are the classes.

    Attributes
    ----------
    classes
        Names of the L classes.
    edges
        Where the score is cut, increasing; n edges make n + 1 levels. A score equal to an edge is of the
        level above it. At most three: tables of more levels need more objects than can be scanned.
    score
        `margin` (`Match.margin`) or `probability` (that of the best class).
    not_recognised
        Whether there is a label for a candidate that the classifier rejects or that cannot be classified;
        otherwise it gets none.
    nothing_seen
        Whether there is a label for a position without a candidate (`Finding.EMPTY`, `Finding.HIDDEN`);
        otherwise it gets none.

    Raises
    ------
    ArgumentError
        If edges do not increase, are not finite or too many, the score is unknown, or two labels have one
        name.

    Examples
    --------
    >>> rule = LabelRule(("livarno", "standard"), edges=(0.2,), not_recognised=True)
    >>> rule.labels
    ('livarno, unsure', 'livarno, sure', 'standard, unsure', 'standard, sure', 'not recognised')
    >>> match = Match(1, np.array([0.0, 1.0]), distances=np.array([3.0, 1.0]))
    >>> match.margin, rule.labels[rule.label(match)]
    (0.5, 'standard, sure')
    >>> LabelRule.from_dict(rule.to_dict()) == rule
    True
    """

    classes: tuple[str, ...]
    edges: tuple[float, ...] = ()
    score: Score = "margin"
    not_recognised: bool = False
    nothing_seen: bool = False

    def __post_init__(self) -> None:
        """Check the settings."""
        if self.score not in get_args(Score):
            raise beltsort.ArgumentError(f"score is {self.score!r}, expected one of {list(get_args(Score))}")
        if len(self.edges) >= MOST_LEVELS:
            raise beltsort.ArgumentError(
                f"there are {len(self.edges)} edges, expected at most {MOST_LEVELS - 1}: leave some out"
            )
        if not np.isfinite(self.edges).all() or (np.diff(self.edges) <= 0.0).any():
            raise beltsort.ArgumentError(
                f"edges are {list(self.edges)}, expected finite numbers, each above the one before: sort them"
            )
        if not self.classes or len(set(self.labels)) < len(self.labels):
            raise beltsort.ArgumentError(
                f"the labels are {list(self.labels)}, expected at least one class and no name twice: rename "
                "classes"
            )

    @property
    def levels(self) -> int:
        """Number of levels of confidence."""
        return len(self.edges) + 1

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Names of the Z labels."""
        names = LEVEL_NAMES[len(self.edges)]
        of_classes = [f"{name}, {level}" if level else name for name in self.classes for level in names]
        others = [(self.not_recognised, NOT_RECOGNISED), (self.nothing_seen, NOTHING_SEEN)]
        return (*of_classes, *(name for there, name in others if there))

    @cached_property
    def label_classes(self) -> tuple[int | None, ...]:
        """The class that each label names, shape (Z,); None for the labels that name no class."""
        named = [label for label in range(len(self.classes)) for _ in range(self.levels)]
        return (*named, *(None for _ in range(len(self.labels) - len(named))))

    def label(self, match: Match | None, finding: Finding = Finding.OBJECT) -> int | None:
        """Return the label of what was seen at one position.

        Parameters
        ----------
        match
            What the classifier returned; None if it was not asked.
        finding
            What was found, where there is no match.

        Returns
        -------
        int or None
            Index into `labels`; None if the rule has no label for it.

        Raises
        ------
        DatabaseError
            If the classifier has other classes, or does not return what `score` needs; a rule of one level
            needs nothing.
        """
        if match is None and finding in WITHOUT_CANDIDATE:
            return self.labels.index(NOTHING_SEEN) if self.nothing_seen else None
        if match is None or match.label is None:
            return self.labels.index(NOT_RECOGNISED) if self.not_recognised else None
        if len(match.scores) != len(self.classes):
            raise DatabaseError(
                f"the classifier scores {len(match.scores)} classes, expected {list(self.classes)}: use the "
                "rule with the classifier that it was fitted with"
            )
        level = bisect_right(self.edges, score_of(match, self.score)) if self.edges else 0
        return match.label * self.levels + level

    def __str__(self) -> str:
        """Return the rule in words, with its labels."""
        return "\n".join([f"LabelRule: {self._in_words()}", *(f"  {name}" for name in self.labels)])

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        numbered = [[str(number), name] for number, name in enumerate(self.labels)]
        return box(f"LabelRule: {self._in_words()}", table(numbered, header=["label", "name"], numbers=False))

    def _in_words(self) -> str:
        if not self.edges:
            return "labels without levels of confidence"
        cuts = " and ".join(f"{edge:.3g}" for edge in self.edges)
        return f"{self.levels} levels of confidence, {self.score} cut at {cuts}"

    def to_dict(self) -> dict[str, object]:
        """Return the rule as plain data for JSON; a model keeps it as its `label_rule`."""
        return {**asdict(self), "classes": list(self.classes), "edges": list(self.edges)}

    @classmethod
    def from_dict(cls, given: object) -> "LabelRule":
        """Return the rule of which `to_dict` returned `given`.

        Raises
        ------
        ArgumentError
            If a key is unknown or missing, or a value is not valid, with all problems.
        """
        from beltsort.util.validation import validated  # needs pydantic, which planning does not

        return validated(cls, given, _no_rule)


def rule_of(model: beltsort.SortingModel) -> LabelRule:
    """Return the rule that makes the labels of a model: its `label_rule`, or the classes if it has none.

    The rule need not know the model's class for empty cups, nor make a label of its name.

    Raises
    ------
    ArgumentError
        If the rule is not valid, or makes other labels than the model's.
    """
    kept = model.label_rule
    rule = LabelRule(tuple(model.classes)) if kept is None else LabelRule.from_dict(kept)
    classes, labels = (without(model.empty, names) for names in (model.classes, model.labels))
    if without(model.empty, rule.classes) != classes or without(model.empty, rule.labels) != labels:
        raise beltsort.ArgumentError(
            f"the model's labels are {model.labels}, expected {list(rule.labels)}, those of its "
            f"{'classes' if kept is None else 'label_rule'}: estimate tables and rule together"
        )
    return rule


def without(empty: str | None, names: Sequence[str]) -> list[str]:
    """Return names without that of the class for empty cups."""
    return [name for name in names if name != empty]


def score_of(match: Match, score: Score) -> float:
    """Return the confidence of a match; rejected ones have one too.

    Raises
    ------
    DatabaseError
        If the classifier does not return what the score is computed from.
    """
    if score == "probability":
        value = None if match.probabilities is None else float(match.probabilities[match.best])
        missing = "probabilities"
    else:
        value, missing = match.margin, "distances"
    if value is None:
        raise DatabaseError(
            f"the classifier returns no {missing}, expected them for the score {score!r}: choose the other "
            "score, or a rule of one level"
        )
    return value


def _no_rule(problems: Sequence[Problem]) -> beltsort.BeltsortError:
    return beltsort.ArgumentError(f"this is no rule of labels: {listed(problems)}")
