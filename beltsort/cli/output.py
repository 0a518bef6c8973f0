"""What the commands print."""

import json
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from beltsort import Decide, Move, SortingModel
from beltsort.util.text import text_table


def print_json(result: Mapping[str, Any]) -> None:
    """Print one JSON object."""
    print(json.dumps(result, indent=2, allow_nan=False))


def tell(line: str) -> None:
    """Print what is not the result: on standard error."""
    print(line, file=sys.stderr)


def print_table(rows: Sequence[Sequence[str]]) -> None:
    """Print rows in columns, the first one flush left."""
    print(text_table(rows))


def action_as_json(model: SortingModel, action: Move | Decide) -> dict[str, str]:
    """Name an action and its object."""
    match action:
        case Move(viewpoint):
            return {"move": model.viewpoints[viewpoint]}
        case Decide(label):
            return {"decide": model.classes[label]}
