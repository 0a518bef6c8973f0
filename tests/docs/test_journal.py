"""docs/journal.md has the schema as it is."""

import re
import sqlite3
from dataclasses import fields
from pathlib import Path
from typing import get_args

from beltsort.sorting.entries import AnyContent, Snapshot
from beltsort.sorting.entry_format import SNAPSHOT_NAMES
from beltsort.sorting.journal import Journal
from beltsort.sorting.journal_files import JOURNAL, VERSION

PAGE = (Path(__file__).parents[2] / "docs" / "journal.md").read_text("utf-8")


def rows_of(head: str) -> list[list[str]]:
    """Return the cells of the tables with a head, without it."""
    tables = [part.partition("\n\n")[0].splitlines()[2:] for part in PAGE.split(f"| {head} |")[1:]]
    return [[cell.strip() for cell in row.strip("|").split(" | ")] for table in tables for row in table]


def test_version_and_columns_are_those_of_a_file(tmp_path: Path) -> None:
    Journal(tmp_path / JOURNAL).close()
    database = sqlite3.connect(tmp_path / JOURNAL)
    assert database.execute("PRAGMA user_version").fetchone() == (VERSION,)
    assert f"\nVersion {VERSION}, the database's `user_version`" in PAGE
    real = [(name, kind) for _, name, kind, *_ in database.execute("PRAGMA table_info(entries)")]
    database.close()
    assert [(name.strip("`"), kind) for name, kind, _ in rows_of("column")] == real


def test_every_kind_has_its_fields() -> None:
    real: dict[str, dict[str, bool]] = {}
    for form in get_args(AnyContent):
        for field in fields(form):
            known = real.setdefault(form.kind, {})
            name = SNAPSHOT_NAMES.get(field.name, field.name) if form is Snapshot else field.name
            known[name] = known.get(name, True) and field.default is None
    documented = {
        kind.strip("`"): {name: bool(bracket) for bracket, name in re.findall(r"(\[?)`(\w+)`", row)}
        for kind, row, _ in rows_of("kind")
    }
    assert documented == real
