"""Finished rows on the disk."""

import hashlib
import json
from pathlib import Path
from typing import Any

from beltsort.errors import SweepError
from beltsort.util.keyed_log import KeyedLog

FILE = "rows.sqlite"


class RowStore(KeyedLog):
    """Rows by the digest of what they depend on.

    Parameters
    ----------
    folder
        Made if it is missing; the rows are in its file `rows.sqlite`.

    Raises
    ------
    SweepError
        If it cannot be read or written.
    """

    table, contents = "points", "rows"
    maker, error = "a sweep", SweepError

    def __init__(self, folder: Path) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as reason:
            raise SweepError(f"the folder {folder} cannot be made: {reason}; name another one") from reason
        super().__init__(folder / FILE)


def digest(*parts: Any) -> str:
    """Name plain data by what it holds, whatever the order of its keys.

    Raises
    ------
    TypeError, ValueError
        If it is no plain data: JSON without NaN and infinities.
    """
    return hashlib.sha256(json.dumps(parts, sort_keys=True, allow_nan=False).encode()).hexdigest()
