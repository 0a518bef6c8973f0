"""Formatting of results as plain text and JSON."""

import math
from collections.abc import Mapping, Sequence


def text_table(rows: Sequence[Sequence[str]]) -> str:
    """Return rows as aligned columns, the first one left-aligned, the others right-aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        first, *others = (cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        lines.append("  ".join(["", row[0].ljust(len(first)), *others]))
    return "\n".join(lines)


def number_or_none(value: float) -> float | None:
    """Return the number, or None if it is not finite, which JSON cannot represent."""
    return value if math.isfinite(value) else None


def numbers_or_none(numbers: Mapping[str, float]) -> dict[str, float | None]:
    """Apply `number_or_none` to the values of a mapping."""
    return {name: number_or_none(value) for name, value in numbers.items()}


def in_words(facts: Mapping[str, str]) -> str:
    """Return facts in one line.

    Examples
    --------
    >>> in_words({"entries": "6 (nut 3, bolt 3)", "distance": "chi2"})
    'entries 6 (nut 3, bolt 3), distance chi2'
    """
    return ", ".join(f"{name} {value}" for name, value in facts.items())


def counted(number: int, noun: str) -> str:
    """Return a number with its noun.

    Examples
    --------
    >>> counted(1, "look"), counted(2, "look")
    ('1 look', '2 looks')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def position_number(index: int) -> str:
    """Return the number of a belt position as people read it.

    They count positions from 1, the belt end. In Python and in files an index of a position counts from 0.

    Examples
    --------
    >>> f"position {position_number(0)} is the belt end"
    'position 1 is the belt end'
    """
    return str(index + 1)


def ranges(numbers: Sequence[int]) -> str:
    """Return numbers, in ascending order, with those that follow each other as ranges.

    Examples
    --------
    >>> ranges([0, 1, 2, 4, 6, 7])
    '0 to 2, 4, 6, 7'
    """
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        elif not runs or number != runs[-1][-1]:
            runs.append([number])
    return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)
