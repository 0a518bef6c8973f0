"""The page in a real browser, for a run that has ended and for one that goes on."""

import shutil
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from beltsort.cell import CommandError
from beltsort.cli.exit_codes import WRONG
from beltsort.planning.explanation import explain
from beltsort.sim import CellConfig
from beltsort.sorting.audit import entries_of, step_of, steps_of
from beltsort.sorting.entries import Scanned
from beltsort.sorting.holds import Answer, HeldError
from beltsort.sorting.journal import entries_after
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.kept_scans import kept_scans, scan_file
from beltsort.sorting.moving.entries import Fate
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import progress_in
from beltsort.sorting.requests import TOKEN, read_request, read_token, taking_requests
from beltsort.watch import Watcher, WatchServer
from tests.cli.running import command
from tests.sorting.moving.runs import BELT, plant, sort
from tests.sorting.test_recovery import PAPER, Controller, begin
from tests.watch.runs import TRUE, sort_bulbs

pytestmark = [pytest.mark.process, pytest.mark.slow]

EXPLAINED = 20_000  # ms


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = shutil.which("chromium")
    assert program is not None, "chromium is not installed: `apt-get install chromium`"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield browser
        browser.close()


@contextmanager
def opened(browser: Browser, url: str) -> Iterator[Page]:
    """Open a page; afterwards it has complained of nothing, and asked nobody but 127.0.0.1."""
    complaints: list[str] = []
    hosts: set[str | None] = set()
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.on("console", lambda message: complaints.append(f"{message.text} {message.location}"))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: hosts.add(urlsplit(request.url).hostname))
    page.goto(url)
    expect(page.locator("#state")).not_to_have_text("…")
    yield page
    page.close()
    assert complaints == []
    assert hosts == {"127.0.0.1"}


@contextmanager
def live(folder: Path) -> Iterator[WatchServer]:
    """Serve a run that goes on, with a scan every half a second, until the block ends."""
    sorting = threading.Thread(
        target=sort_bulbs,
        args=[folder],
        kwargs={"true": TRUE * 5, "delay": 0.5, "allow_hold": True, "check": (ended := Ended())},
        daemon=True,
    )
    with taking_requests(folder):
        sorting.start()
        deadline = time.monotonic() + 60
        while "plan" not in kinds(folder):
            assert time.monotonic() < deadline
            time.sleep(0.1)
        with WatchServer(Watcher(folder)) as server:
            yield server
        ended.now = True
        sorting.join(timeout=60)
        assert not sorting.is_alive()


class Ended:
    """Ends a run when told to."""

    now = False

    def __call__(self) -> None:
        if self.now:
            raise KeyboardInterrupt


def kinds(folder: Path) -> list[str]:
    return [entry.kind for entry in entries_after(folder / "journal.sqlite", 0)]


def beliefs(page: Page) -> list[list[str]]:
    """Return the numbers beside the bars of each position, the belt end first."""
    return [
        position.locator(":scope > .bar .number").all_inner_texts()
        for position in page.locator(".position").all()
    ]


def formatted(rows: list[list[float]]) -> list[list[str]]:
    return [[f"{round(p, 4):.2f}" for p in row] for row in rows]


def to_step(page: Page, step: int) -> None:
    page.locator("#slider").fill(str(step))
    expect(page.locator("#belt-note")).to_have_text(f"before step {step}")


def test_the_slider_goes_through_a_run_that_has_ended(finished: Path, browser: Browser) -> None:
    entries = entries_of(finished)
    steps = list(steps_of(entries))
    with WatchServer(Watcher(finished)) as server, opened(browser, server.url) as page:
        expect(page.locator("#state")).to_have_text("Complete")
        expect(page.locator("#progress")).to_contain_text("6 of 6 objects")
        expect(page.locator("#step")).to_have_text(f"now, {len(steps)} steps")
        expect(page.locator("#bins tr")).to_have_count(4)
        assert page.locator(".position").count() == 2
        for step in (steps[0], steps[3], steps[5]):
            to_step(page, step.number)
            assert beliefs(page) == formatted(step.belief.probabilities.tolist())
            expect(page.locator(".position h3").first).to_contain_text(f"object {step.entry.object}")
            assert page.locator("#values .chosen").count() == 1
        page.locator("#forth").click()
        expect(page.locator("#step")).to_have_text(f"step {steps[5].number + 1} of {len(steps)}")
        page.locator("#now").click()
        expect(page.locator("#step")).to_have_text(f"now, {len(steps)} steps")
        assert not page.locator("#control").is_visible()
        expect(page.locator("#alarms li")).to_have_count(1)
        page.locator("body").press("ArrowLeft")
        expect(page.locator("#step")).to_have_text(f"step {len(steps)} of {len(steps)}")


def test_a_choice_is_explained_in_words(finished: Path, browser: Browser) -> None:
    step = step_of(entries_of(finished), 2)
    plan = step.plan_again()
    assert plan is not None
    with WatchServer(Watcher(finished)) as server, opened(browser, server.url) as page:
        to_step(page, 2)
        expect(page.locator("#explanation")).to_have_text(explain(step.model, plan), timeout=EXPLAINED)


def test_four_positions_and_their_bins(four: Path, browser: Browser) -> None:
    step = step_of(entries_of(four), 3)
    with WatchServer(Watcher(four)) as server, opened(browser, server.url) as page:
        to_step(page, 3)
        assert beliefs(page) == formatted(step.belief.probabilities.tolist())
        assert page.locator(".position").count() == 4
        assert page.locator(".position").first.locator(".of-bins .name").all_inner_texts() == [
            "→ long",
            "→ round",
        ]
        assert page.locator("#bins td:first-child").all_inner_texts()[:3] == ["long", "round", "by hand"]


@pytest.mark.parametrize("width", [390, 1280])
def test_a_belt_that_never_stops(tmp_path: Path, browser: Browser, width: int) -> None:
    sort(tmp_path, plant())
    watcher = Watcher(tmp_path)
    last = watcher.state().run.last_step
    with WatchServer(watcher) as server, opened(browser, server.url) as page:
        page.set_viewport_size({"width": width, "height": 800})
        expect(page.locator("#state")).to_have_text("Complete")
        expect(page.locator("#progress")).to_contain_text("12 of 12 objects")
        expect(page.locator("#step")).to_have_text(f"now, {last} steps")
        expect(page.locator("#scene-note")).to_have_text("the run has kept no scan yet")
        for step in (1, last // 2, last):
            to_step(page, step)
            moment = watcher.state(step).run.moment
            for row, position in zip(beliefs(page), moment.positions, strict=True):
                assert [float(p) for p in row] == pytest.approx(position.belief, abs=0.0051)
            expect(page.locator(".position h3").first).to_have_text(f"object {moment.object} exit")
            decided = [f"decided: {each.decided}" for each in moment.positions if each.decided]
            assert page.locator(".decided").all_inner_texts() == decided
            assert page.locator("#values .chosen").count() == 1
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            where = BELT.model.viewpoints[moment.viewpoint]
            expect(page.locator("#plan-note")).to_have_text(f"step {step}, camera at {where}")
        expect(page.locator("#explanation")).to_be_hidden()


def test_how_objects_have_left_a_belt_that_never_stops(tmp_path: Path, browser: Browser) -> None:
    cell = plant(objects=20)
    checks = count()

    def check() -> None:
        if next(checks) == 50:
            cell.belt.restart()

    lost = sort(tmp_path, cell, check=check).fates[Fate.LOST]
    assert lost > 0
    with WatchServer(Watcher(tmp_path)) as server, opened(browser, server.url) as page:
        expect(page.locator("#figures div", has_text="lost")).to_have_text(f"lost{lost}")
        assert page.locator("#figures dt", has_text="forced").count() == 0
        expect(page.locator("#alarms-note")).to_contain_text("1 restart")
        expect(page.locator("#alarms-note")).to_contain_text(f"{lost} lost")


def drawn(page: Page, canvas: str) -> str:
    """Return the picture of a canvas, PNG in base 64."""
    return str(page.evaluate("(id) => document.getElementById(id).toDataURL()", canvas))


def test_the_cloud_is_drawn_and_turned(finished: Path, browser: Browser) -> None:
    with WatchServer(Watcher(finished)) as server, opened(browser, server.url) as page:
        expect(page.locator("#scene-note")).to_contain_text("at the belt end")
        before = [drawn(page, name) for name in ("cloud", "sphere")]
        blank = page.evaluate("document.createElement('canvas').toDataURL()")
        assert min(map(len, before)) > 5 * len(blank)
        box = page.locator("#cloud").bounding_box()
        assert box is not None
        page.mouse.move(box["x"] + 100, box["y"] + 100)
        page.mouse.down()
        page.mouse.move(box["x"] + 180, box["y"] + 120)
        page.mouse.up()
        for name, picture in zip(("cloud", "sphere"), before, strict=True):
            assert drawn(page, name) != picture


def test_the_cloud_is_that_of_the_step(finished: Path, tmp_path: Path, browser: Browser) -> None:
    shutil.copytree(finished, tmp_path, dirs_exist_ok=True)
    oldest, *_ = kept_scans(tmp_path)
    scan_file(tmp_path, oldest).unlink()
    with WatchServer(Watcher(tmp_path)) as server, opened(browser, server.url) as page:
        names = CellConfig().viewpoints
        entries = entries_of(tmp_path)
        expect(page.locator("#scene-note")).to_contain_text("at the belt end")
        pictures = {drawn(page, "cloud")}
        scans = [entry for entry in entries if isinstance(entry.content, Scanned)]
        for step in list(steps_of(entries))[-3:]:
            scan = [entry for entry in scans if entry.number < step.entry.number][-1]
            assert isinstance(scan.content, Scanned)
            to_step(page, step.number)
            where = f"from {names[scan.content.viewpoint].name}, object {scan.object} at the belt end"
            expect(page.locator("#scene-note")).to_have_text(where)
            pictures.add(drawn(page, "cloud"))
        assert len(pictures) > 1
        to_step(page, 1)
        expect(page.locator("#scene-note")).to_have_text("there was no scan before this step")
        to_step(page, 2)
        expect(page.locator("#scene-note")).to_contain_text("is no longer kept: the run keeps the latest")
        assert drawn(page, "cloud") not in pictures
        page.locator("#now").click()
        expect(page.locator("#scene-note")).to_contain_text("at the belt end")
        assert drawn(page, "cloud") in pictures


@pytest.mark.parametrize("width", [390, 800, 1280])
def test_nothing_sticks_out(four: Path, browser: Browser, width: int) -> None:
    with WatchServer(Watcher(four)) as server, opened(browser, server.url) as page:
        page.set_viewport_size({"width": width, "height": 800})
        to_step(page, 3)
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_live_run_is_followed_held_and_continued(tmp_path: Path, browser: Browser) -> None:
    with live(tmp_path) as server, opened(browser, f"{server.url}#token={read_token(tmp_path)}") as page:
        assert page.url == server.url
        expect(page.locator("#state")).to_have_text("Execute")
        page.locator("#hold").click()
        expect(page.locator("#state")).to_have_text("Held", timeout=20_000)
        expect(page.locator("#notice")).to_contain_text("asked to hold")
        progress = Progress.after(entries_of(tmp_path))
        assert beliefs(page) == formatted(progress.belief.probabilities.tolist())
        time.sleep(1.0)
        assert Progress.after(entries_of(tmp_path)).steps == progress.steps
        page.locator("#continue").click()
        expect(page.locator("#state")).to_have_text("Execute", timeout=20_000)
        expect(page.locator("#step")).not_to_have_text(f"now, {progress.steps} steps", timeout=20_000)
        page.reload()
        expect(page.locator("#hold")).to_be_enabled()


@pytest.mark.parametrize("width", [390, 1280])
def test_a_question_is_answered_by_a_button(tmp_path: Path, browser: Browser, width: int) -> None:
    cell = Controller(PAPER, breaks={"sort": [CommandError]})
    with pytest.raises(HeldError), taking_requests(tmp_path):
        begin(tmp_path, cell)
    with WatchServer(Watcher(tmp_path)) as server:
        with opened(browser, server.url) as page:
            expect(page.locator("#question")).to_contain_text("settle it as not-done")
            assert page.locator("#question button").count() == 0
        with opened(browser, f"{server.url}#token={read_token(tmp_path)}") as page:
            page.set_viewport_size({"width": width, "height": 800})
            expect(page.locator("#notice")).to_contain_text("was broken off")
            expect(page.locator("#notice")).not_to_contain_text("--settle")
            assert page.locator("#question button").all_inner_texts() == ["done", "not-done"]
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            page.locator("#question button").first.click()
            expect(page.locator("#question")).to_contain_text("answered: done; resume the run")
            expect(page.locator("#question button").last).to_be_disabled()
    assert progress_in(tmp_path / JOURNAL).settled is Answer.DONE


def test_without_the_token_a_run_is_only_watched(tmp_path: Path, browser: Browser) -> None:
    with live(tmp_path) as server, opened(browser, server.url) as page:
        expect(page.locator("#state")).to_have_text("Execute")
        assert not page.locator("#control").is_visible()
        assert read_request(tmp_path) is None


def test_a_wrong_token_is_refused(tmp_path: Path, browser: Browser) -> None:
    with live(tmp_path) as server:
        page = browser.new_page()
        page.goto(f"{server.url}#token=wrong")
        page.locator("#hold").click()
        expect(page.locator("#notice")).to_contain_text("this needs the run's token")
        assert read_request(tmp_path) is None
        page.close()


def test_a_page_that_has_lost_its_server_says_so(finished: Path, browser: Browser) -> None:
    page = browser.new_page()
    with WatchServer(Watcher(finished)) as server:
        page.goto(server.url)
        expect(page.locator("#state")).to_have_text("Complete")
    expect(page.locator("#state")).to_have_text("No answer")
    expect(page.locator("#notice")).to_contain_text("has ended")
    page.close()


def test_control_needs_a_run_that_takes_requests(finished: Path) -> None:
    done = command("watch", str(finished), "--control", "--no-browser")
    assert done.returncode == WRONG
    assert TOKEN in done.stderr
    assert "--allow-hold" in done.stderr
