"""What was varied in a study, and how it is named: what claims, figures and report need beside the rows."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from beltsort.paper.instances import OBJECTS, Objects
from beltsort.paper.outcomes import LABELS, SCANS, STUDY
from beltsort.paper.policies import (
    INFORMATION_GAIN,
    OPTIMUM,
    PLANNERS,
    POLICIES,
    PUBLISHED,
    RECOMMENDED,
    THRESHOLD,
)
from beltsort.paper.printed import R_MIN

SHOWN = (RECOMMENDED, OPTIMUM, THRESHOLD, INFORMATION_GAIN, PUBLISHED)
"""The paper's policies in the order of figures."""


@dataclass(frozen=True)
class Source:
    """Where the labels of some rows come from.

    Attributes
    ----------
    title
        For figures and headings.
    level
        `LABELS` or `SCANS`.
    instance
        Name of the tables.
    """

    title: str
    level: str
    instance: str

    @property
    def condition(self) -> dict[str, str]:
        """What its rows have in common."""
        return {"level": self.level, "instance": self.instance}


@dataclass(frozen=True)
class Outline:
    """What was varied in a study, and how it is named.

    Attributes
    ----------
    name
        `paper`, or `own` for a model or policies of one's own; the column `study` of its rows.
    title
        Heading of the report.
    tables
        What the tables of each instance are called, by its name.
    sources
        Where labels come from, a row of panels each.
    objects
        Sets of objects, a column of panels each; the offline solution is of the last.
    positions
        Numbers of belt positions seen at once, the fewest first.
    policies
        Those of the paper that apply, then those of one's own.
    r_min
        Penalty of a wrong decision at which claims are tested.
    ticks
        Penalties that axes name.
    left_out
        Sentences on what is missing, and why.
    """

    name: str
    title: str
    tables: dict[str, str]
    sources: tuple[Source, ...]
    objects: tuple[Objects, ...]
    positions: tuple[int, ...]
    policies: tuple[str, ...]
    r_min: float
    ticks: tuple[float, ...]
    left_out: tuple[str, ...] = ()

    @property
    def of_the_paper(self) -> bool:
        """Whether it is of the paper's tables and of the simulated cell."""
        return self.name == STUDY

    @property
    def own_policies(self) -> tuple[str, ...]:
        """Policies that the paper does not have."""
        return tuple(name for name in self.policies if name not in POLICIES)

    @property
    def judged(self) -> tuple[str, ...]:
        """Policies that claims are about: the planners, and those of one's own."""
        return (*(name for name in PLANNERS if name in self.policies), *self.own_policies)

    @property
    def shown(self) -> tuple[str, ...]:
        """All policies in the order of figures, the offline solution among them."""
        papers = (name for name in SHOWN if name in self.policies or name == OPTIMUM)
        return (*papers, *self.own_policies)

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Outline":
        """Return the one that `dataclasses.asdict` has made plain data, also after JSON.

        Raises
        ------
        KeyError, TypeError
            If keys are missing or unknown.
        """
        sources = tuple(Source(**source) for source in plain["sources"])
        objects = tuple(Objects(each["name"], tuple(each["classes"])) for each in plain["objects"])
        lists = {name: tuple(plain[name]) for name in ("positions", "policies", "ticks", "left_out")}
        return cls(**{**plain, **lists, "sources": sources, "objects": objects})


THE_PAPER = Outline(
    name=STUDY,
    title="Sorting objects from a conveyor belt: the paper's experiments again",
    tables={"paper": "the paper's tables", "cell": "the simulated cell's tables"},
    sources=(
        Source("labels from the paper's tables", LABELS, "paper"),
        Source("labels from the cell's tables", LABELS, "cell"),
        Source("depth scans of the cell", SCANS, "cell"),
    ),
    objects=OBJECTS,
    positions=(1, 2),
    policies=POLICIES,
    r_min=R_MIN,
    ticks=(5.0, 20.0, 50.0, 200.0, 500.0),
)


def positions_in_words(number: int) -> str:
    """Return a number of belt positions as text.

    Examples
    --------
    >>> [positions_in_words(number) for number in (1, 2, 3)]
    ['one position', 'two positions', '3 positions']
    """
    return {1: "one position", 2: "two positions"}.get(number, f"{number} positions")
