"""Calls that are refused, and what their messages name."""

import json
import re
from collections.abc import Callable
from typing import Any

import pytest
from numpy.typing import ArrayLike

from beltsort import BeltsortError, SortingModel

Case = tuple[Callable[[], object], type[BeltsortError], list[str]]
"""A call, the type of its exception, and parts of the message."""

TABLES = [[[[0.5, 0.5], [0.1, 0.9]]]]


def model(p_obs: ArrayLike = TABLES, **settings: Any) -> Callable[[], object]:
    arguments: dict[str, Any] = {"classes": ["a", "b"], "viewpoints": ["v"]} | settings
    return lambda: SortingModel(p_obs=p_obs, **arguments)


def file(**keys: object) -> Callable[[], object]:
    return lambda: SortingModel.from_json(json.dumps({"classes": ["a", "b"], "viewpoints": ["v"]} | keys))


def tells(message: str, part: str) -> bool:
    """A part counts as a whole word or number: no 1 is in 0.1, -1 or 100."""
    return re.search(rf"(?<![\w.-]){re.escape(part)}(?!\w|\.\d)", message) is not None


def check_refused(case: Case) -> None:
    call, kind, parts = case
    with pytest.raises(BeltsortError) as raised:
        call()
    assert type(raised.value) is kind
    missing = [part for part in parts if not tells(str(raised.value), part)]
    assert not missing, str(raised.value)
