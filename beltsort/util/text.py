"""Results and messages as plain text and as JSON."""

import math
from collections.abc import Mapping, Sequence


def text_table(rows: Sequence[Sequence[str]]) -> str:
    """Lay out rows in columns, the first one flush left."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        first, *others = (cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        lines.append("  ".join(["", row[0].ljust(len(first)), *others]))
    return "\n".join(lines)


def number_or_none(value: float) -> float | None:
    """Return the number, or None where JSON has no way to write it."""
    return value if math.isfinite(value) else None


def numbers_or_none(numbers: Mapping[str, float]) -> dict[str, float | None]:
    """Do the same for named numbers."""
    return {name: number_or_none(value) for name, value in numbers.items()}
