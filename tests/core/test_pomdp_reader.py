"""The reader of the tests, on the format's own example: Cassandra's tiger."""

import numpy as np

from .pomdp_reader import read_pomdp

TIGER = """
# The tiger of Kaelbling, Littman & Cassandra (1998), with every way to write a table.
discount: 0.95
values: reward
states: tiger-left tiger-right
actions: listen open-left open-right
observations: 2
start: uniform
T: listen
identity
T: open-left
uniform
T: 2 : * : tiger-left 0.5
T: 2 : *
0.5 0.5
O: * uniform
O: listen
0.85 0.15
0.15 0.85
R: listen : * : * : * -1
R: open-left : tiger-left : * : * -100.0   # a later line overrides
R: open-left : tiger-right : * : * 99
R: open-left : tiger-right : tiger-left : 1 10
R: open-right : tiger-left
10 10
10 10
"""


def test_tiger() -> None:
    tiger = read_pomdp(TIGER)
    assert (tiger.discount, tiger.values, tiger.observations) == (0.95, "reward", ["0", "1"])
    assert tiger.start.tolist() == [0.5, 0.5]
    assert np.array_equal(tiger.transitions, [np.eye(2), np.full((2, 2), 0.5), np.full((2, 2), 0.5)])
    assert np.array_equal(tiger.labels[0], [[0.85, 0.15], [0.15, 0.85]])
    assert np.array_equal(tiger.labels[1:], np.full((2, 2, 2), 0.5))
    assert np.array_equal(tiger.rewards[0], np.full((2, 2, 2), -1.0))
    assert tiger.rewards[1].tolist() == [[[-100.0, -100.0]] * 2, [[99.0, 10.0], [99.0, 99.0]]]
    assert np.array_equal(tiger.rewards[2], [np.full((2, 2), 10.0), np.zeros((2, 2))])
