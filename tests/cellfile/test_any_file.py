"""Whatever stands in a cell file, it is described or refused in words."""

import tomllib
from contextlib import suppress
from datetime import date
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.cellfile.composed import compose
from beltsort.cellfile.description import CellDescription, contradictions
from beltsort.cellfile.validation import validated
from beltsort.errors import CellError
from tests.cellfile.cell_files import EXAMPLE
from tests.cellfile.test_cell_docs import TOML
from tests.laws import cases

FILES = [tomllib.loads(text) for text in (EXAMPLE.read_text(), TOML[0], TOML[0] + TOML[1] + TOML[-1])]

SCALARS = st.one_of(
    st.text(max_size=5), st.integers(), st.floats(), st.booleans(), st.just(date(2020, 1, 1)),
    st.sampled_from([0, 1, -1, 1e300, "simulated", "dry-run", [], {}]),
)  # fmt: skip
VALUES = st.one_of(
    SCALARS, st.lists(SCALARS, max_size=4), st.dictionaries(st.text(max_size=5), SCALARS, max_size=2)
)


def places(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the way to every value of nested tables and arrays."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else []
    below = [place for key, value in items for place in places(value, (*path, key))]
    return [path, *below] if path else below


def replaced(tree: Any, path: tuple[Any, ...], value: Any) -> Any:
    """Return the tree with one value replaced, or left out if it is None."""
    if not path:
        return value
    key, *rest = path
    copy = tree.copy()
    copy[key] = replaced(tree[key], tuple(rest), value)
    if copy[key] is None:
        del copy[key]
    return copy


@pytest.mark.slow
@cases(100)
@given(st.data())
def test_a_changed_file_is_described_or_refused(data: st.DataObject) -> None:
    file = data.draw(st.sampled_from(FILES))
    for _ in range(data.draw(st.integers(1, 2))):
        path = data.draw(st.sampled_from(places(file)))
        file = replaced(file, path, data.draw(st.one_of(st.none(), VALUES)))
    with suppress(CellError):  # any other error fails
        cell = validated(CellDescription, file)
        list(contradictions(cell))
        compose(cell, live=False, say=print)
