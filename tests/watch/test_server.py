"""The server: what it answers, and to whom."""

import http.client
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell import CommandError
from beltsort.cli.operator import CommandLineOperator
from beltsort.errors import JournalError
from beltsort.sorting.audit import entries_of, step_of
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.kept_scans import KeptScan, kept_scans, scan_file
from beltsort.sorting.record import progress_in
from beltsort.sorting.requests import TOKEN, read_request, read_token, taking_requests
from beltsort.watch import Watcher, WatchServer
from tests.sorting.test_recovery import PAPER, Controller, begin, go_on, sorts


@pytest.fixture
def server(finished: Path) -> Iterator[WatchServer]:
    with WatchServer(Watcher(finished)) as server:
        yield server


def ask(
    server: WatchServer, path: str, method: str = "GET", headers: dict[str, str] | None = None
) -> tuple[int, str, http.client.HTTPMessage]:
    connection = http.client.HTTPConnection(server.url.split("/")[2], timeout=20)
    connection.request(method, path, headers=headers or {})
    answer = connection.getresponse()
    body = answer.read().decode()
    connection.close()
    return answer.status, body, answer.headers


def json_of(server: WatchServer, path: str) -> dict[str, Any]:
    status, body, headers = ask(server, path)
    assert (status, headers["Content-Type"]) == (200, "application/json"), body
    content = json.loads(body)
    assert isinstance(content, dict)
    return content


def test_the_page_and_its_files(server: WatchServer) -> None:
    for path, kind in [
        ("/", "text/html"),
        ("/style.css", "text/css"),
        ("/page.js", "text/javascript"),
        ("/scene.js", "text/javascript"),
    ]:
        status, body, headers = ask(server, path)
        assert status == 200
        assert headers["Content-Type"].startswith(kind)
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert "http:" not in body.replace("http://www.w3.org", "")
        assert "https:" not in body


def test_the_run_now_and_before_a_step(server: WatchServer) -> None:
    now = json_of(server, "/api/state")
    assert now["run"]["state"] == "Complete"
    assert not now["takes_requests"]
    then = json_of(server, "/api/state?step=2")["run"]["moment"]
    assert then["step"] == 2
    assert then["plan"]["step"] == 2
    assert ask(server, "/api/state?step=999")[0] == 404
    assert ask(server, "/api/state?step=two")[0] == 400


def test_the_last_scan(server: WatchServer, finished: Path) -> None:
    scene, kept = json_of(server, "/api/scene"), json_of(server, "/api/state")["kept_scan"]
    assert scene["entry"] == kept
    assert len(scene["points"]) == 3 * len(scene["positions"])
    assert set(scene["positions"]) <= {-1, 0, 1}
    assert 0 in scene["positions"]
    assert len(scene["viewpoints"]) == 3
    assert scene["layout"] == [2, 180.0, 50.0, 40.0]
    scanned = [entry.number for entry in entries_of(finished) if entry.kind == "scan"]
    assert kept == scanned[-1]


def test_the_scan_before_a_step(server: WatchServer, finished: Path) -> None:
    now = json_of(server, "/api/scene")
    for step in (1, 3, 6):
        state, scene = json_of(server, f"/api/state?step={step}"), json_of(server, f"/api/scene?step={step}")
        scan = state["run"]["moment"]["scan"]
        assert state["kept_scan"] == scene["entry"] == (scan and scan["entry"])
        assert (scene["missing"] == "") == (scan is not None) == (scene["points"] != [])
        assert scene["layout"] == now["layout"]
        if scan is not None:
            kept = KeptScan.load(scan_file(finished, scan["entry"]))
            assert len(kept.points) == len(scene["positions"])
            assert scene["points"] != now["points"]
    assert ask(server, "/api/scene?step=999")[0] == 404


def test_a_scan_that_is_no_longer_kept(finished: Path, tmp_path: Path) -> None:
    shutil.copytree(finished, tmp_path, dirs_exist_ok=True)
    for entry in kept_scans(finished)[:-2]:
        scan_file(tmp_path, entry).unlink()
    latest = scan_file(tmp_path, kept_scans(tmp_path)[-1])
    with WatchServer(Watcher(tmp_path)) as server:
        then, scene = json_of(server, "/api/state?step=2"), json_of(server, "/api/scene?step=2")
        assert (then["kept_scan"], then["kept_scans"], scene["entry"], scene["points"]) == (None, 2, None, [])
        assert (
            scene["missing"] == "the cloud of this scan is no longer kept: the run keeps the latest 2 scans"
        )
        assert len(scene["viewpoints"]) == 3
        assert json_of(server, "/api/scene?step=1")["missing"] == "there was no scan before this step"
        assert json_of(server, "/api/scene")["missing"] == ""
        latest.unlink()
        assert json_of(server, "/api/scene")["missing"] == "the cloud of this scan is not kept"


def test_a_run_without_a_scan(finished: Path, tmp_path: Path) -> None:
    (tmp_path / "journal.sqlite").write_bytes((finished / "journal.sqlite").read_bytes())
    with WatchServer(Watcher(tmp_path)) as server:
        assert json_of(server, "/api/state")["kept_scan"] is None
        status, body, _ = ask(server, "/api/scene")
    assert status == 404
    assert "kept no scan" in body


def test_an_explanation_is_that_of_the_plan(server: WatchServer, finished: Path) -> None:
    text = json_of(server, "/api/explanation?step=1")["text"]
    plan = step_of(entries_of(finished), 1).plan_again()
    assert plan is not None
    assert "one more look, from" in text
    assert "most likely:" in text
    assert ask(server, "/api/explanation?step=999")[0] == 404


@pytest.mark.parametrize(
    "path",
    [
        "/../watcher.py",
        "/page/index.html",
        "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/journal.sqlite",
        "/api/",
    ],
)
def test_there_is_nothing_else(server: WatchServer, path: str) -> None:
    assert ask(server, path)[0] == 404


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "evil.example:80"},
        {"Host": ""},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
    ],
)
@pytest.mark.parametrize("method", ["GET", "POST"])
def test_pages_of_other_sites_get_no_answer(
    server: WatchServer, headers: dict[str, str], method: str
) -> None:
    status, body, _ = ask(server, "/api/state" if method == "GET" else "/api/hold", method, headers)
    assert status == 403
    assert "run" not in json.loads(body)


def test_it_listens_on_this_computer_only(server: WatchServer) -> None:
    assert server.url.startswith("http://127.0.0.1:")
    assert (
        ask(
            server, "/api/state", headers={"Host": server.url.split("/")[2].replace("127.0.0.1", "localhost")}
        )[0]
        == 200
    )


def control(server: WatchServer, path: str, token: str, method: str = "POST") -> int:
    return ask(server, path, method, {"Authorization": f"Bearer {token}"})[0]


def test_a_request_needs_the_token(finished: Path, tmp_path: Path) -> None:
    (tmp_path / "journal.sqlite").write_bytes((finished / "journal.sqlite").read_bytes())
    with WatchServer(Watcher(tmp_path)) as server:
        assert control(server, "/api/hold", "") == 403  # the run takes none
        with taking_requests(tmp_path):
            token = read_token(tmp_path)
            assert token is not None
            assert (tmp_path / TOKEN).stat().st_mode & 0o777 == 0o600
            assert json_of(server, "/api/state")["takes_requests"]
            assert token not in json.dumps(json_of(server, "/api/state"))
            for wrong in ("", token[:-1], token + "x", "ä"):
                assert control(server, "/api/hold", wrong) == 403
            assert control(server, "/api/hold", token, method="GET") == 404
            assert ask(server, f"/api/hold?token={token}", "POST")[0] == 404
            assert control(server, "/api/stop", token) == 404
            assert read_request(tmp_path) is None
            assert control(server, "/api/hold", token) == 200
            assert (hold := read_request(tmp_path)) is not None
            assert hold.action == "hold"
            assert "beltsort watch" in hold.by
            assert control(server, "/api/continue", token) == 200
            assert (go_on := read_request(tmp_path)) is not None
            assert go_on.action == "continue"
        assert control(server, "/api/hold", token) == 403  # the run has ended


def test_watching_leaves_the_folder_as_it_is(finished: Path) -> None:
    before = {file.name: file.stat().st_mtime_ns for file in finished.iterdir()}
    with WatchServer(Watcher(finished)) as server:
        json_of(server, "/api/state")
        json_of(server, "/api/explanation?step=1")
        assert {file.name: file.stat().st_mtime_ns for file in finished.iterdir()} == before
    assert {file.name: file.stat().st_mtime_ns for file in finished.iterdir()} == before


def test_a_damaged_scan_is_no_scan(finished: Path, tmp_path: Path) -> None:
    first, *_, last = kept_scans(finished)
    for entry, content in ((first, b""), (last, scan_file(finished, last).read_bytes()[:-100])):
        (tmp_path / "scan.npz").write_bytes(content)
        with pytest.raises(JournalError, match=r"scan\.npz cannot be read as a scan .*delete it"):
            KeptScan.load(tmp_path / "scan.npz")
        shutil.copytree(finished, tmp_path / str(entry))
        scan_file(tmp_path / str(entry), first).write_bytes(content)
        with WatchServer(Watcher(tmp_path / str(entry))) as server:
            scene = json_of(server, "/api/scene?step=2")
        assert scene["entry"] is None
        assert "cannot be read" in scene["missing"]


def test_a_question_is_answered_with_the_token(tmp_path: Path) -> None:
    cell = Controller(PAPER, breaks={"sort": [CommandError]})
    with pytest.raises(HeldError), taking_requests(tmp_path):
        begin(tmp_path, cell)
    token = read_token(tmp_path)
    assert token is not None
    with WatchServer(Watcher(tmp_path)) as server:
        question = json_of(server, "/api/state")["run"]["question"]
        assert [way["answer"] for way in question["ways"]] == ["done", "not-done"]
        assert question["settled"] is None
        path = f"/api/settle/done/{question['entry']}"
        assert control(server, path, "") == 403
        assert control(server, f"/api/settle/done/{question['entry'] - 1}", token) == 409  # an earlier page
        assert control(server, path.replace("done", "passed"), token) == 409
        assert control(server, path.replace("done", "eaten"), token) == 404
        assert json_of(server, "/api/state")["run"]["question"]["settled"] is None
        assert control(server, path, token) == 200
        assert json_of(server, "/api/state")["run"]["question"]["settled"] == "done"
        assert "(beltsort watch)" in json_of(server, "/api/state")["run"]["alarms"][0]["text"]
        go_on(tmp_path, cell, CommandLineOperator(None, progress_in(tmp_path / JOURNAL)))
        assert json_of(server, "/api/state")["run"]["question"] is None
    assert len(sorts(cell)) == 1
