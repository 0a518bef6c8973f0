"""The page of a run on a belt that never stops: what the server answers, also while the run goes on."""

import json
from contextlib import ExitStack
from itertools import count
from pathlib import Path

from beltsort.sorting.moving.state import MovingState
from beltsort.sorting.requests import read_request, read_token, taking_requests
from beltsort.watch import Watcher, WatchServer
from beltsort.watch.state import RunView
from tests.sorting.moving.runs import check_accounts, entries, plant, sort
from tests.watch.moving import check_shown
from tests.watch.test_server import ask, control, json_of


def test_the_server_shows_such_a_run(moving: Path) -> None:
    with WatchServer(Watcher(moving)) as server:
        now, then = json_of(server, "/api/state"), json_of(server, "/api/state?step=2")
        assert now["run"]["moving"]
        assert now["run"]["moment"]["tally"]["fates"]["in bin"] > 0
        assert then["run"]["moment"]["plan"]["step"] == 2
        assert (now["kept_scan"], now["kept_scans"]) == (None, 0)
        for path, text in (("scene", "kept no scan"), ("explanation", "cannot be planned again")):
            status, body, _ = ask(server, f"/api/{path}?step=2")
            assert (status, text in json.loads(body)["error"]) == (404, True)


def test_a_run_that_goes_on_is_followed(tmp_path: Path) -> None:
    shown: list[RunView] = []
    states: list[MovingState] = []
    checks = count(1)
    watcher: Watcher | None = None

    def look() -> None:
        nonlocal watcher
        watcher = watcher or Watcher(tmp_path)
        shown.append(watcher.state().run)
        states.append(MovingState.after(entries(tmp_path)))

    def check() -> None:
        if next(checks) in (10, 40):
            look()

    sort(tmp_path, plant(), check=check)
    look()
    for run, state in zip(shown, states, strict=True):
        check_shown(run, state)
    assert [run.state for run in shown] == ["Execute", "Execute", "Complete"]
    assert 0 < shown[0].last_step < shown[1].last_step < shown[2].last_step
    assert [bool(run.moment.doing) for run in shown] == [True, True, False]


def test_a_run_is_held_and_continued_through_the_server(tmp_path: Path) -> None:
    cell, told = plant(), list[str]()
    server: WatchServer | None = None

    def check() -> None:
        nonlocal server  # it begins when the journal has its first entries
        server = server or stack.enter_context(WatchServer(Watcher(tmp_path)))
        state = json_of(server, "/api/state")
        told.append(state["run"]["state"])
        token = read_token(tmp_path)
        assert token is not None
        if len(told) == 20:
            assert state["takes_requests"]
            assert control(server, "/api/hold", "wrong") == 403
            assert control(server, "/api/hold", token) == 200
        if told[-1] == "Held":
            assert not cell.belt.reading().moving
            assert control(server, "/api/continue", token) == 200
            cell.belt.start()

    with taking_requests(tmp_path), ExitStack() as stack:
        sort(tmp_path, cell, check=check, requests=tmp_path)
    assert told.count("Held") == 1
    request = read_request(tmp_path)
    assert request is not None
    assert (request.action, "beltsort watch" in request.by) == ("continue", True)
    shown = Watcher(tmp_path).state().run
    assert (shown.state, shown.alarm_counts) == ("Complete", {"held": 1, "operator": 1})
    check_accounts(tmp_path, cell)
