"""Rows as a Parquet file."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from beltsort.errors import SweepError
from beltsort.util.extras import extra


def load_pyarrow() -> Any:
    """Return the package pyarrow, which is imported on first use only.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    with extra("sweep"):
        import pyarrow.parquet
    return pyarrow


def write_rows(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """Write a column for each key; the file is replaced as a whole.

    A column whose values are of several kinds, numbers and lists for example, is written as JSON.

    Raises
    ------
    SweepError
        If the file cannot be written.
    """
    pyarrow = load_pyarrow()
    names = dict.fromkeys(name for row in rows for name in row)
    table = pyarrow.table({name: _column(pyarrow, [row.get(name) for row in rows]) for name in names})
    half_done = path.with_suffix(".part")
    try:
        with half_done.open("wb") as file:
            pyarrow.parquet.write_table(table, file)
            file.flush()
            os.fsync(file.fileno())
        half_done.replace(path)
    except OSError as reason:
        raise SweepError(
            f"{path} cannot be written: {reason}; expected room on the disk and a folder that can be "
            "written: the finished rows are kept beside it, make room and run the same again"
        ) from reason
    finally:
        half_done.unlink(missing_ok=True)


def _column(pyarrow: Any, values: list[Any]) -> Any:
    try:
        return pyarrow.array(values)
    except (pyarrow.ArrowInvalid, pyarrow.ArrowTypeError):
        return pyarrow.array([None if value is None else json.dumps(value) for value in values])
