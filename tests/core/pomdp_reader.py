"""A reader of Cassandra's POMDP format that knows nothing of sorting.

It follows http://www.pomdp.org/code/pomdp-file-spec.html: numbers or names, `*` for all, single entries, rows
and matrices, `identity` and `uniform`; a later line overrides an earlier one.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

KEYWORDS = "discount|values|states|actions|observations|start|T|O|R"


@dataclass(frozen=True, eq=False)
class Pomdp:
    discount: float
    values: str
    states: list[str]
    actions: list[str]
    observations: list[str]
    start: NDArray[np.float64]  # (S,)
    transitions: NDArray[np.float64]  # (A, S, S), [action, state, next state]
    labels: NDArray[np.float64]  # (A, S, Z), [action, next state, observation]
    rewards: NDArray[np.float64]  # (A, S, S, Z), [action, state, next state, observation]


def read_pomdp(text: str) -> Pomdp:
    text = re.sub(r"#.*", "", text)
    pieces = re.split(rf"^\s*({KEYWORDS})\s*:", text, flags=re.MULTILINE)
    assert not pieces[0].strip()
    statements = list(zip(pieces[1::2], pieces[2::2], strict=True))
    preamble = {key: body.split() for key, body in statements if key not in {"T", "O", "R"}}
    states, actions, observations = (names(preamble[key]) for key in ("states", "actions", "observations"))
    s, a, z = len(states), len(actions), len(observations)
    tables = {"T": np.zeros((a, s, s)), "O": np.zeros((a, s, z)), "R": np.zeros((a, s, s, z))}
    axes = {
        "T": (actions, states, states),
        "O": (actions, states, observations),
        "R": (actions, states, states, observations),
    }
    for key, body in statements:
        if key in tables:
            fill(tables[key], axes[key], body)
    return Pomdp(
        discount=float(preamble["discount"][0]),
        values=preamble["values"][0],
        states=states,
        actions=actions,
        observations=observations,
        start=start(preamble, states),
        transitions=tables["T"],
        labels=tables["O"],
        rewards=tables["R"],
    )


def names(words: Sequence[str]) -> list[str]:
    if len(words) == 1 and words[0].isdecimal():
        return [str(i) for i in range(int(words[0]))]
    assert len(set(words)) == len(words)
    assert all(re.fullmatch(r"[A-Za-z][\w-]*", word, re.ASCII) for word in words)
    return list(words)


def fill(table: NDArray[np.float64], axes: Sequence[list[str]], body: str) -> None:
    """Set the entries that one `T:`, `O:` or `R:` statement speaks of."""
    *parts, last = (part.split() for part in body.split(":"))
    indices = [*(part[0] for part in parts), last[0]]
    part = table[tuple(index(word, axis) for word, axis in zip(indices, axes, strict=False))]
    part[...] = entries(last[1:], table.shape[len(indices) :])


def index(word: str, axis: list[str]) -> slice:
    if word == "*":
        return slice(None)
    number = int(word) if word.isdecimal() else axis.index(word)
    return slice(number, number + 1)


def entries(words: Sequence[str], shape: tuple[int, ...]) -> NDArray[np.float64]:
    if words == ["identity"]:
        return np.eye(shape[0])
    if words == ["uniform"]:
        return np.full(shape, 1 / shape[-1])
    return numbers(words).reshape(shape)


def numbers(words: Sequence[str]) -> NDArray[np.float64]:
    assert all(re.fullmatch(r"[+-]?\d+(\.\d+)?", word) for word in words), "no exponents in this format"
    return np.array([float(word) for word in words])


def start(preamble: dict[str, list[str]], states: list[str]) -> NDArray[np.float64]:
    if "start" not in preamble or preamble["start"] == ["uniform"]:
        return np.full(len(states), 1 / len(states))
    words = preamble["start"]
    if len(words) == 1 and len(states) > 1:
        return np.asarray(np.eye(len(states))[states.index(words[0])])
    return numbers(words)
