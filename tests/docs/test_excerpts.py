"""The comparison of a shown output with the printed one."""

import pytest

from tests.docs.excerpts import shows

PRINTED = ["a 1", "b 2", "c 3", "d 4"]


@pytest.mark.parametrize(
    "shown",
    [
        ["a 1", "b 2", "c 3", "d 4"],
        ["a 1", "...", "d 4"],
        ["...", "b 2", "...", "d 4"],
        ["a 1", "b 2", "..."],
    ],
)
def test_excerpts(shown: list[str]) -> None:
    assert shows(shown, PRINTED)


@pytest.mark.parametrize(
    "shown",
    [
        ["a 1", "c 3", "d 4"],
        ["a 1", "...", "b 2", "..."],
        ["...", "c 3", "...", "b 2", "..."],
        ["b 2", "..."],
        ["a 1", "...", "c 3"],
        ["a 1", "b 2", "c 3", "d 4", "..."],
        ["...", "a 1", "b 2", "c 3", "d 4"],
        ["a 1", "...", "c 9", "..."],
    ],
)
def test_wrong_excerpts(shown: list[str]) -> None:
    assert not shows(shown, PRINTED)
