"""A sweep on a Dask cluster gives the rows of a sweep on this machine."""

import json
import socket
from pathlib import Path

import pytest
from distributed import Client

from beltsort.cli import main
from beltsort.errors import SweepError
from beltsort.sweep.cluster import Certificates, Cluster
from beltsort.sweep.engine import RowStore, run_points
from tests.sweep import tasks
from tests.sweep.certificates import make_certificates
from tests.sweep.cluster_processes import cluster
from tests.sweep.test_file import MODEL, PLANNER, load
from tests.sweep.test_sweep import SCANS
from tests.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.process

POINTS = 20


def test_a_worker_that_is_killed_loses_and_doubles_no_row(tmp_path: Path) -> None:
    notes, store, gate = tmp_path / "notes", tmp_path / "store", tmp_path / "gate"
    points = [{"x": x, "notes": str(notes), "gate": str(gate)} for x in range(POINTS)]
    del points[0]["gate"]
    with cluster(tmp_path, workers=2) as processes:
        with Client(processes.address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=PATIENCE)

        def at_the_gate() -> list[int]:
            begun = (map(int, line.split()) for line in notes.read_text().splitlines())
            return [pid for x, pid in begun if x > 0]

        def kill_midway(done: int, _total: int) -> None:
            """Kill a worker that is at work, when the one point that need not wait is finished."""
            if done == 1:
                pid = wait_until(at_the_gate, "a worker waits at the gate")[0]
                (victim,) = (worker for worker in processes.workers if worker.pid == pid)
                victim.kill()
                victim.wait()
                gate.touch()

        rows = run_points(
            tasks.noted, points, store, scheduler=Cluster(processes.address), progress=kill_midway
        )
        assert [worker.poll() is None for worker in processes.workers].count(False) == 1
    assert [row["square"] for row in rows] == [x * x for x in range(POINTS)]
    with RowStore(store) as kept:
        assert sorted(row["x"] for row in kept.values().values()) == list(range(POINTS))
    begun = notes.read_text()
    assert run_points(tasks.noted, points, store, workers=1) == rows
    assert notes.read_text() == begun


@pytest.mark.parametrize(
    "text", [f"seeds = 3\n{MODEL}{PLANNER}[tables]\nbatches = 2", SCANS], ids=["tables", "scans"]
)
def test_the_command_gives_the_rows_of_this_machine(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    local = load(tmp_path, text)
    with cluster(tmp_path, workers=1) as processes:
        given = ["sweep", str(tmp_path / "sweep.toml"), "--scheduler", processes.address, "--json"]
        assert main(given) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert rows == local.run(tmp_path / "local", workers=1)


def test_a_task_that_fails_is_named(tmp_path: Path) -> None:
    points = [{"x": x} for x in range(2, 4)]
    with cluster(tmp_path, workers=1) as processes, pytest.raises(SweepError, match=r'\{"x": 3\}.*no threes'):
        run_points(tasks.failing_at_three, points, tmp_path / "store", scheduler=Cluster(processes.address))


def test_over_tls_both_sides_are_certified(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ours, foreign = (make_certificates(new_folder(tmp_path / name)) for name in ("ours", "foreign"))
    options = (
        *("--tls-ca-file", str(ours.authority)),
        *("--tls-cert", str(ours.certificate), "--tls-key", str(ours.key)),
    )
    points = [{"x": x} for x in range(3)]
    with cluster(tmp_path, workers=1, options=options) as processes:
        assert processes.address.startswith("tls://127.0.0.1:")
        known = Cluster(processes.address, ours)
        rows = run_points(tasks.square, points, tmp_path / "store", scheduler=known)
        assert [row["square"] for row in rows] == [0, 1, 4]
        monkeypatch.setattr("beltsort.sweep.cluster.CONNECTING", 2.0)
        stranger = Cluster(processes.address, foreign)
        with pytest.raises(SweepError, match=r"tls://127\.0\.0\.1.*certificate.*`dask scheduler`"):
            run_points(tasks.square, points, tmp_path / "other", scheduler=stranger)


def new_folder(path: Path) -> Path:
    path.mkdir()
    return path


def test_a_scheduler_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("beltsort.sweep.cluster.CONNECTING", 0.5)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nobody = Cluster(f"127.0.0.1:{free.getsockname()[1]}")
        with pytest.raises(SweepError, match=r"scheduler\b.*tcp://127\.0\.0\.1.*`dask scheduler`"):
            run_points(tasks.square, [{"x": 1}], tmp_path, scheduler=nobody)


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        (
            "tcp://192.0.2.1:8786",
            r"tcp://192\.0\.2\.1:8786\b.*tls://.*--tls-ca, --tls-cert and --tls-key",
        ),
        ("farm.example:8786", r"--scheduler tcp://farm\.example:8786\b.*tls://"),
        (
            "tls://192.0.2.1:8786",
            r"tls://192\.0\.2\.1:8786\b.*--tls-ca, --tls-cert and --tls-key",
        ),
        ("tcp://127.0.0.1", r"tcp://127\.0\.0\.1\b.*tcp://HOST:PORT.*tls://HOST:PORT"),
        ("tcp://127.0.0.1:many", r"tcp://127\.0\.0\.1:many\b.*tcp://HOST:PORT"),
        ("ucx://127.0.0.1:8786", r"ucx://127\.0\.0\.1:8786\b.*tcp://HOST:PORT"),
    ],
)
def test_addresses_that_are_refused(address: str, reason: str) -> None:
    with pytest.raises(SweepError, match=reason):
        Cluster(address)


def test_addresses_of_this_machine() -> None:
    assert Cluster("localhost:8786").address == "tcp://localhost:8786"
    assert Cluster("tcp://[::1]:8786").address == "tcp://[::1]:8786"


def test_certificates_must_be_there_and_of_use(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=r"\bca\.pem\b.*\bPEM\b"):
        Certificates(*(tmp_path / name for name in ("ca.pem", "cert.pem", "key.pem")))
    (tmp_path / "file").touch()
    files = Certificates(tmp_path / "file", tmp_path / "file", tmp_path / "file")
    with pytest.raises(SweepError, match=r"--scheduler tcp://127\.0\.0\.1:8786\b.*certificates.*tls://"):
        Cluster("tcp://127.0.0.1:8786", files)
