"""Old runs are printed, and removed when asked to."""

import os
from pathlib import Path

from beltsort.sorting.locks import locked
from beltsort.sorting.runs import LOCK
from tests.cli.cells import cell_file
from tests.cli.running import command, json_of
from tests.sorting.test_retention import run_in


def test_the_command(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    for name in ("1", "2", "3"):
        run_in(runs / name)
    with locked("the run", runs / "1" / LOCK):
        printed = command("prune", str(runs), "--keep", "1").stdout
    assert f"kept: {runs / '1'}: it is in use by process {os.getpid()}" in printed
    assert "1 run would be removed, 0.0 MB; --yes removes them" in printed
    found = json_of("prune", str(runs), "--older-than", "52w")
    assert (found["removed"], [Path(old["folder"]).name for old in found["old"]]) == (False, ["1", "2"])
    assert json_of("prune", str(runs), "--keep", "2", "--older-than", "52w", "--yes")["removed"]
    assert sorted(folder.name for folder in runs.iterdir()) == ["2", "3"]
    for words in ([], ["--keep", "0"], ["--older-than", "30"], ["--keep", "1", "nowhere"]):
        assert command("prune", *([] if "nowhere" in words else [str(runs)]), *words).returncode == 2
    assert sorted(folder.name for folder in runs.iterdir()) == ["2", "3"]


def test_a_new_run_removes_old_ones_of_its_cell(folder: Path) -> None:
    cell = cell_file(folder, ("objects = 10", "objects = 1\nkeep_runs = 2"))
    run_in(folder / "runs" / "2020-of-another-cell", "b")
    run_in(folder / "runs" / "2021-of-another-cell", "b")
    for _ in range(4):
        assert command("run", cell).returncode == 0
    runs = sorted(path.name for path in (folder / "runs").iterdir())
    assert runs[:2] == ["2020-of-another-cell", "2021-of-another-cell"]
    assert len(runs) == 2 + 3, "the newest, and two before it"
