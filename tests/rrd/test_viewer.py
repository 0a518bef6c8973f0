"""A recording in rerun's web viewer, drawn without a graphics card."""

import io
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import quote, urlsplit

import numpy as np
import pytest
import rerun_cli
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Error, Page, Route, sync_playwright

from beltsort.rrd.scene import class_colour
from tests.ports import HeldPort
from tests.waiting import wait_until

from .conftest import RecordedRun

pytestmark = [pytest.mark.process, pytest.mark.slow]

SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
PATIENCE = 300.0  # seconds; a software renderer on a busy machine
MARGIN = 40  # of a colour's red, green and blue; curves are thin and their edges smoothed


@contextmanager
def served(rrd: Path, home: Mapping[str, str]) -> Iterator[str]:
    """Serve a recording and rerun's web viewer; yield the page's address."""
    # The program itself: the script of that name starts it in a process of its own, which would stay.
    program = str(Path(rerun_cli.__file__).with_name("rerun"))
    with HeldPort() as page, HeldPort() as data:
        ports = ["--port", str(data.number), "--web-viewer-port", str(page.number)]
        command = [program, str(rrd), "--serve-web", "--bind", "127.0.0.1", *ports]
        with subprocess.Popen(
            command, env=home, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as server:
            try:
                source = quote(f"rerun+http://127.0.0.1:{data.number}/proxy", safe="")
                yield f"http://127.0.0.1:{page.number}/?url={source}&renderer=webgl"
            finally:
                server.terminate()


def only_here(route: Route) -> None:
    """Let the page ask nobody else."""
    if urlsplit(route.request.url).hostname == "127.0.0.1":
        route.continue_()
    else:
        route.abort()


def seen(page: Page) -> NDArray[np.int64]:
    """Return what the page shows, shape (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(np.int64)


def count(pixels: NDArray[np.int64], colour: list[int]) -> int:
    """Return how many pixels have about this colour."""
    return int((np.abs(pixels - colour).max(axis=-1) <= MARGIN).sum())


def test_the_viewer_shows_candidates_and_beliefs(run: RecordedRun, home: Mapping[str, str]) -> None:
    chromium = shutil.which("chromium")
    assert chromium is not None, "chromium is not installed: `apt-get install chromium`"
    with served(run.rrd, home) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=list(SOFTWARE))
        page = browser.new_page(viewport={"width": 1200, "height": 800})
        page.route("**/*", only_here)
        page.set_default_timeout(60_000)
        wait_until(lambda: loaded(page, address), "the server", PATIENCE)
        wait_until(lambda: shown(page), "a recording on the page", PATIENCE)
        browser.close()


def loaded(page: Page, address: str) -> bool:
    """Go to a page; return whether its server was there."""
    try:
        page.goto(address)
    except Error:
        return False
    return True


def shown(page: Page) -> bool:
    """Return whether the page shows curves of both classes beside a cell that is more than an empty panel."""
    try:
        pixels = seen(page)
    except Error:  # the renderer is busy
        return False
    middle = pixels.shape[1] // 2
    cell, curves = pixels[:, :middle], pixels[:, middle:]
    colours = np.unique(cell.reshape(-1, 3), axis=0)
    return len(colours) > 300 and min(count(curves, class_colour(i)) for i in (0, 1)) > 100
