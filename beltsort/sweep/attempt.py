"""One point, wherever it is run: what comes of it is plain data, a failure too."""

import json
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import beltsort

Point: TypeAlias = Mapping[str, Any]
Row: TypeAlias = dict[str, Any]
Task: TypeAlias = Callable[[Mapping[str, Any]], Mapping[str, Any]]


@dataclass(frozen=True)
class Attempt:
    """What came of a point.

    Attributes
    ----------
    row
        The point and its result, or None.
    failure, trace
        What went wrong, in a line and in full; empty if nothing did.
    """

    row: Row | None
    failure: str = ""
    trace: str = ""


def attempt(task: Task, version: str, point: Point) -> Attempt:
    """Run a task on a point, by the version of beltsort that the row is to be of.

    Any exception becomes text: exceptions of other packages need not survive the way between processes.
    """
    try:
        if beltsort.__version__ != version:
            raise ValueError(
                f"a worker has beltsort {beltsort.__version__}, expected {version}: install that"
            )
        result = dict(task(point))
        if taken := sorted(result.keys() & point.keys()):
            raise ValueError(f"the result names {', '.join(taken)}, which the point has: rename it")
        return Attempt(json.loads(json.dumps({**point, **result}, allow_nan=False)))
    except Exception as error:
        return Attempt(None, f"{type(error).__name__}: {error}", traceback.format_exc())
