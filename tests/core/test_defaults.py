"""Default values are defined once, in the core; documentation and Python repeat no other numbers."""

import inspect
import re

import pytest

import beltsort
from beltsort import SortingModel, _core
from beltsort.sorting.rules import Rules

DOCUMENTED: dict[str, dict[str, float]] = {
    "evaluate": {
        "batches": _core.DEFAULT_BATCHES,
        "batch_size": _core.DEFAULT_BATCH_SIZE,
        "max_looks": _core.DEFAULT_MAX_LOOKS,
    },
    "Despot": {"scenarios": _core.DEFAULT_SCENARIOS},
    "LookAhead": {"depth": _core.DEFAULT_LOOK_AHEAD_DEPTH, "scenarios": _core.DEFAULT_SCENARIOS},
    "InformationGain": {"positions": _core.DEFAULT_INFORMATION_POSITIONS},
    "solve": {"seconds": _core.DEFAULT_SOLVE_SECONDS},
}


def documented(name: str) -> dict[str, float]:
    found = re.findall(r"^(\w+) : [^\n]*, default ([\d.]+)$", getattr(beltsort, name).__doc__, re.MULTILINE)
    return {parameter: float(value) for parameter, value in found}


@pytest.mark.parametrize("name", DOCUMENTED)
def test_docstrings_tell_the_defaults(name: str) -> None:
    assert documented(name) == DOCUMENTED[name]


def test_docstring_of_the_model_tells_its_defaults(paper: SortingModel) -> None:
    plain = SortingModel(paper.classes, paper.viewpoints, paper.p_obs)
    shown = documented("SortingModel")
    assert shown == {name: getattr(plain, name) for name in ("r_max", "r_min", "discount")}


def test_defaults_apply(paper: SortingModel) -> None:
    assert beltsort.Despot(paper).settings["scenarios"] == _core.DEFAULT_SCENARIOS
    result = beltsort.evaluate(paper, beltsort.Threshold(paper, 0.9))
    assert len(result.steps) == _core.DEFAULT_BATCHES
    assert result.correct.max() <= _core.DEFAULT_BATCH_SIZE


def test_comparisons_have_the_defaults_of_evaluations() -> None:
    parameters = inspect.signature(beltsort.compare).parameters
    for name, value in DOCUMENTED["evaluate"].items():
        assert parameters[name].default == value


def test_loop_and_simulation_have_the_same_rules() -> None:
    assert Rules().max_looks == _core.DEFAULT_MAX_LOOKS
    assert Rules().impossible_labels == _core.MAX_IMPOSSIBLE_LABELS
