"""Messages about kinds, labels, bins and rewards: the value, what is expected, and the remedy."""

import numpy as np
import pytest

from beltsort import ArgumentError, BeltsortError, ModelError

from .bad_input import TABLES, Case, check_refused, file, model

REWARD = [[1.0, -1.0], [-1.0, 1.0]]

CASES: dict[str, Case] = {
    "labels twice": (model(labels=["x", "x"]), ModelError, ["labels", '["x", "x"]', "twice", "rename"]),
    "empty label": (model(labels=["x", ""]), ModelError, ["labels", '["x", ""]', "empty"]),
    "no labels": (model(labels=[]), ModelError, ["labels", "[]", "0", "1"]),
    "bins twice": (model(bins=["x", "x"], reward=REWARD), ModelError, ["bins", '["x", "x"]', "rename"]),
    "no bins": (model(bins=[], reward=[[]]), ModelError, ["bins", "[]", "0", "1"]),
    "labels in p_obs": (
        model(labels=["x", "y", "z"]),
        ModelError,
        ["p_obs[0][0][0]", "2", "3", "one per label"],
    ),
    "last axis of p_obs": (
        model([[[[0.5, 0.5, 0.0], [0.1, 0.9, 0.0]]]]),
        ModelError,
        ["p_obs[0][0][0]", "3", "2", "observed class", "labels"],
    ),
    "kinds in p_obs": (
        model(modes=[[1.0], [0.5, 0.5]]),
        ModelError,
        ["p_obs[0][0]", "2", "3", "one per mode of each class"],
    ),
    "rows of p_obs": (
        model([[[[0.5, 0.5], [0.1, 0.9], [0.2, 0.8]]]]),
        ModelError,
        ["p_obs[0][0]", "3", "2", "true class", "give modes"],
    ),
    "modes of each class": (model(modes=[[1.0]]), ModelError, ["modes", "1", "2", "class"]),
    "sum of modes": (
        model(modes=[[1.0], [0.5, 0.4]]),
        ModelError,
        ["modes", '"b"', "[0.5, 0.4]", "0.9", "1", "Divide"],
    ),
    "negative mode": (model(modes=[[1.0], [1.5, -0.5]]), ModelError, ["modes", '"b"', "-0.5"]),
    "no modes": (model(modes=[[1.0], []]), ModelError, ["modes", '"b"', "[]", "[1.0]"]),
    "bins without reward": (
        model(bins=["x", "y"]),
        ModelError,
        ["bins", '["x", "y"]', "give reward"],
    ),
    "reward rows": (model(reward=[[1.0, -1.0]]), ModelError, ["reward", "1", "2", "bin"]),
    "reward columns": (
        model(reward=[[1.0], [1.0]]),
        ModelError,
        ["reward[0]", "1", "2", "class"],
    ),
    "reward axes": (model(reward=[1.0, -1.0]), ModelError, ["reward", "[2]", "two axes", "rows"]),
    "ragged reward": (model(reward=[[1.0, -1.0], [1.0]]), ModelError, ["reward", "inhomogeneous"]),
    "reward of words": (model(reward="high"), ModelError, ["reward", "high", "array"]),
    "infinite reward": (
        model(reward=[[1.0, -np.inf], [-1.0, 1.0]]),
        ModelError,
        ["reward", "-inf", "finite"],
    ),
    "no reward above 0": (
        model(reward=[[0.0, -1.0], [-1.0, -2.0]]),
        ModelError,
        ["reward", "[[0.0, -1.0], [-1.0, -2.0]]", "0", "above 0"],
    ),
    "reward with r_min": (model(reward=REWARD, r_min=5.0), ModelError, ["reward", "r_min", "5", "leave"]),
    "reward with r_max": (model(reward=REWARD, r_max=5.0), ModelError, ["reward", "r_max", "5", "leave"]),
    "reward with r_min in a file": (
        file(p_obs=TABLES, reward=REWARD, r_min=5.0),
        ModelError,
        ["reward", "r_min", "5.0", "leave"],
    ),
    "counts of other labels": (
        model(
            [[[[0.5, 0.2, 0.3], [0.1, 0.8, 0.1]]]],
            labels=["x", "y", "z"],
            counts=[[[[1, 2], [3, 4]]]],
        ),
        ModelError,
        ["counts", "p_obs", "(H, K, L, Z)"],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_keys(case: str) -> None:
    check_refused(CASES[case])


@pytest.mark.parametrize("kind", [ArgumentError, ModelError])
def test_wrong_values_are_value_errors(kind: type[Exception]) -> None:
    assert issubclass(kind, ValueError)
    assert issubclass(kind, BeltsortError)
