"""A cell that is trained once, on little, and one tiny reproduction on it."""

import json
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from beltsort import paper
from beltsort.cli import main
from beltsort.paper import Reproduction
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_counts, collect_training
from beltsort.sim.prepare import Prepared

from .tiny import SEED, TINY


@pytest.fixture(scope="session")
def prepared() -> Prepared:
    database = collect_training(CellConfig(), objects=2, seed=SEED, workers=1)
    counts = collect_counts(database, CellConfig(), objects=1, seed=SEED, workers=1)
    return Prepared(database, counts, objects=1, seconds={}, source="made")


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("reproduction")


@dataclass(frozen=True)
class Commanded:
    """What `beltsort reproduce --json` made, and what it printed."""

    made: Reproduction
    printed: dict[str, Any]


@pytest.fixture(scope="session")
def commanded(prepared: Prepared, folder: Path) -> Commanded:
    """The command, without interruption, in one process."""
    made: list[Reproduction] = []

    def reproduce(*arguments: Any, **named: Any) -> Reproduction:
        made.append(paper.reproduction.reproduce(*arguments, **named))
        return made[-1]

    printed = StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(printed):
        patch.setattr("beltsort.sim.prepare.prepare", lambda progress: prepared)
        patch.setattr(paper, "QUICK", TINY)
        patch.setattr(paper, "reproduce", reproduce)
        command = ["reproduce", "--quick", "-o", str(folder), "--seed", str(SEED), "--workers", "1", "--json"]
        assert main(command) == 0
    return Commanded(made[0], json.loads(printed.getvalue()))


@pytest.fixture(scope="session")
def reproduction(commanded: Commanded) -> Reproduction:
    return commanded.made
