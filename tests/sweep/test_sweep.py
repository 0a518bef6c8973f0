"""`beltsort sweep`, from its file to Parquet."""

import errno
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from pyarrow import parquet

from beltsort.cli import main
from beltsort.errors import SweepError
from beltsort.sweep.engine import RowStore
from beltsort.sweep.parquet import write_rows
from beltsort.sweep.run import Sweep
from tests.sweep.test_file import MODEL, PLANNER, load

pytestmark = pytest.mark.process

TABLES = f"""
seeds = 3
{MODEL}
r_min = [5, 50]
[planner]
policy = ["threshold:0.9", "despot:5"]
scenarios = 50
[tables]
batches = 2
batch_size = 3
"""
SCANS = """
level = "scans"
seeds = 2
[planner]
policy = ["threshold:0.8"]
[cell]
classes = [["elongated", "livarno"]]
viewpoints = [[{name = "p2", azimuth = 180.0, elevation = 45.0}]]
arm.position = 0.001
[scans]
objects = 1
training_objects = 1
table_objects = 1
"""
LIMITED = """
import resource, signal, sys
from beltsort.cli import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
sys.exit(main(sys.argv[1:]))
"""


def test_rows_are_the_same_for_any_number_of_processes(tmp_path: Path) -> None:
    sweep = load(tmp_path, TABLES)
    one, two = (sweep.run(tmp_path / str(workers), workers=workers) for workers in (1, 2))
    assert one == two
    assert len(one) == 2 * 2 * 3
    assert parquet.read_table(tmp_path / "1" / "rows.parquet").to_pylist() == one


def test_the_command_prints_one_object_and_resumes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "grid.toml").write_text(TABLES)
    given = ["sweep", str(tmp_path / "grid.toml"), "--workers", "1"]
    assert main([*given, "--json"]) == 0
    first = capsys.readouterr()
    assert "points 0 of 12 done before" in first.err
    rows = json.loads(first.out)["rows"]
    assert main(given) == 0
    again = capsys.readouterr()
    assert "points 12 of 12 done before" in again.err
    assert len(again.out.splitlines()) == 1 + len(rows) + 1
    assert parquet.read_table(tmp_path / "grid" / "rows.parquet").num_rows == len(rows)


def test_what_is_there_is_written_after_an_interruption(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = load(tmp_path, TABLES)

    def interrupt(done: int, _total: int) -> None:
        if done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep.run(tmp_path / "rows", workers=1, progress=interrupt)
    there = parquet.read_table(tmp_path / "rows" / "rows.parquet").to_pylist()
    assert there == sweep.run(tmp_path / "rows", workers=1)[:5]


def test_a_full_disk_is_named_and_costs_no_finished_row(tmp_path: Path) -> None:
    path, folder = tmp_path / "grid.toml", tmp_path / "grid"
    path.write_text(f"seeds = 20\n{MODEL}{PLANNER}[tables]\nbatches = 2")
    given = ["sweep", str(path), "--workers", "1"]
    done = subprocess.run([sys.executable, "-c", LIMITED, *given], capture_output=True, text=True)
    assert done.returncode == 2
    (error,) = (line for line in done.stderr.splitlines() if line.startswith("beltsort: error: "))
    assert re.search(r"rows\.sqlite\b.*\bdisk\b", error)
    with RowStore(folder) as store:
        kept = store.values()
    assert 0 < len(kept) < 20
    told: list[int] = []
    rows = Sweep.load(path).run(folder, workers=1, progress=lambda done, _total: told.append(done))
    assert told[0] == len(kept)
    assert rows == Sweep.load(path).run(tmp_path / "fresh", workers=1)


def test_a_parquet_file_that_cannot_be_written_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "rows.parquet"
    write_rows([{"a": 1}], path)

    def full(_file: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(SweepError, match=r"rows\.parquet\b.*No space left"):
        write_rows([{"a": 2}], path)
    assert list(tmp_path.iterdir()) == [path]
    assert parquet.read_table(path).to_pylist() == [{"a": 1}]


def test_columns_of_several_kinds_are_json(tmp_path: Path) -> None:
    write_rows([{"a": 1, "b": 1}, {"a": [1, 2], "b": 2.5}, {"a": None}], tmp_path / "rows.parquet")
    columns = parquet.read_table(tmp_path / "rows.parquet").to_pydict()
    assert columns == {"a": ["1", "[1, 2]", None], "b": [1.0, 2.5, None]}


def test_scans(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    sweep = load(tmp_path, SCANS)
    sweep.prepare()
    assert len(list((tmp_path / "cache" / "beltsort").iterdir())) == 1
    rows = sweep.run(tmp_path / "rows", workers=1)
    assert [(row["cell.arm.position"], row["seed"]) for row in rows] == [(0.001, 0), (0.001, 1)]
    assert all(row["decided"] == 1 and row["looks"] >= 1 for row in rows)
    assert rows == sweep.run(tmp_path / "two", workers=2)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--tls-ca", "ca.pem"], r"--tls-ca, --tls-cert, --tls-key\b.*--scheduler\b"),
        (
            ["--scheduler", "tls://127.0.0.1:1", "--tls-ca", "ca.pem"],
            r"\ball\b.*--tls-cert, --tls-key\b",
        ),
        (["--scheduler", "127.0.0.1:1", "--workers", "2"], r"--workers\b.*\bcluster\b"),
        (["--scheduler", "192.0.2.1:1"], r"--scheduler tcp://192\.0\.2\.1:1\b.*tls://"),
    ],
)
def test_options_that_do_not_go_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], reason: str
) -> None:
    (tmp_path / "grid.toml").write_text(TABLES)
    assert main(["sweep", str(tmp_path / "grid.toml"), *options]) == 2
    assert re.search(reason, capsys.readouterr().err)
