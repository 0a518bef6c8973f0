"""How the results of a reproduction were made."""

import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import beltsort
from beltsort.paper.design import QUICK, Design
from beltsort.paper.outline import THE_PAPER, Outline
from beltsort.paper.study import Study
from beltsort.util.machine import installed_version, processor_name, processors

LIBRARIES = ("numpy", "scipy", "matplotlib", "open3d")


@dataclass(frozen=True)
class Circumstances:
    """How the results of a report were made.

    Attributes
    ----------
    command
        The command line or function call.
    seed
        Seed of all experiments.
    design
        Sizes, penalties and settings.
    outline
        What was varied, and its names.
    facts
        Versions, machine and times as text, by name.
    """

    command: str
    seed: int
    design: Design
    facts: Mapping[str, str] = field(default_factory=dict)
    outline: Outline = THE_PAPER

    @classmethod
    def now(cls, command: str, seed: int, study: Study, seconds: Mapping[str, float]) -> "Circumstances":
        """Return those of a run that ends now; `seconds` are the durations of its stages, by name."""
        facts = {
            "versions": ", ".join(
                [f"beltsort {beltsort.__version__}", f"Python {platform.python_version()}"]
                + [f"{name} {installed_version(name)}" for name in LIBRARIES]
            ),
            "machine": f"{processor_name()}, {processors()} processors, {platform.platform()}",
            "finished": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
            "seconds, this time": ", ".join(f"{name} {value:.0f}" for name, value in seconds.items()),
        }
        return cls(command, seed, study.design, facts, study.outline)

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Circumstances":
        """Return those that `dataclasses.asdict` has made plain data, also after JSON.

        Raises
        ------
        KeyError, TypeError
            If keys are missing or unknown.
        """
        outline = Outline.from_plain(plain["outline"]) if "outline" in plain else THE_PAPER
        design: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in {"speeds": [], **plain["design"]}.items()  # files before there were any
        }
        return cls(**{**plain, "design": Design(**design), "outline": outline})

    @property
    def quick(self) -> bool:
        """Whether it was of few batches."""
        return self.design.batches <= QUICK.batches

    def rows(self) -> dict[str, str]:
        """Return everything but the design as text, by name."""
        return {"made by": self.command, "seed": str(self.seed), **self.facts}
