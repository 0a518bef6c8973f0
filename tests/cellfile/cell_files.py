"""Cell files for tests."""

from pathlib import Path
from typing import Any

from beltsort.cellfile.composed import ComposedCell, compose
from beltsort.cellfile.description import CellDescription

NOTHING_SIMULATED = (
    ('"simulated"', '"dry-run"'),
    ('[backends.simulated]\ndraw_from = ["elongated", "livarno"]\nseed = 0\n', ""),
)
"""Changes after which no device of the example is there."""

EXAMPLE = Path(__file__).parents[2] / "beltsort" / "cellfile" / "examples" / "simulated.toml"


def changed(folder: Path, *changes: tuple[str, str], example: Path = EXAMPLE) -> Path:
    """Write an example with pieces of its text replaced, and return its path."""
    text = example.read_text()
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path = folder / "cell.toml"
    path.write_text(text)
    return path


def described(folder: Path, *changes: tuple[str, str]) -> CellDescription:
    return CellDescription.load(changed(folder, *changes))


def composed(folder: Path, *changes: tuple[str, str], **settings: Any) -> ComposedCell:
    return compose(described(folder, *changes), **{"live": False, "say": print, **settings})
