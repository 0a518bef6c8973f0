from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.cell.simulated import CellConfig
from beltsort.tables.prepare import Prepared, prepare


def small(cache: Path, config: CellConfig | None = None) -> Prepared:
    return prepare(config, training_objects=1, table_objects=1, cache=cache)


def test_cache_is_used_mended_and_keyed_by_the_configuration(tmp_path: Path) -> None:
    made = small(tmp_path)
    again = small(tmp_path)
    assert (made.cached, again.cached) == (False, True)
    np.testing.assert_array_equal(made.counts.counts, again.counts.counts)
    np.testing.assert_array_equal(made.database.descriptors, again.database.descriptors)

    (counts,) = tmp_path.glob("*/counts.npz")
    counts.write_bytes(counts.read_bytes()[:100])
    mended = small(tmp_path)
    assert not mended.cached
    np.testing.assert_array_equal(made.counts.counts, mended.counts.counts)
    assert len(list(tmp_path.iterdir())) == 1, "no half-written entry stays"

    assert not small(tmp_path, CellConfig(size_spread=0.1)).cached


def test_unwritable_cache_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(beltsort.BeltsortError, match=r"cache folder .* cannot be written"):
        small(tmp_path / "file")
