"""A recording in rerun's web viewer, drawn without a graphics card."""

import io
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import quote, urlsplit

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Page, Route, sync_playwright

from beltsort.rrd.scene import class_colour
from tests.ports import HeldPort

from .conftest import RecordedRun

pytestmark = [pytest.mark.process, pytest.mark.slow]

SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
PATIENCE = 300.0  # seconds; a software renderer on a busy machine
MARGIN = 12  # of a colour's red, green and blue


@contextmanager
def served(rrd: Path, home: Mapping[str, str]) -> Iterator[str]:
    """Serve a recording and rerun's web viewer; yield the page's address."""
    program = shutil.which("rerun", path=str(Path(sys.executable).parent))
    assert program is not None
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
    return np.asarray(Image.open(io.BytesIO(page.screenshot(timeout=60_000))).convert("RGB")).astype(np.int64)


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
        end = time.monotonic() + PATIENCE
        while True:
            assert time.monotonic() < end, "nothing is shown"
            try:
                if page.url == "about:blank":
                    page.goto(address, timeout=60_000)
                pixels = seen(page)
            except Exception:  # the server is not there yet, or the renderer is busy
                time.sleep(1.0)
                continue
            _, width, _ = pixels.shape
            curves, cell = pixels[:, width // 2 :], pixels[:, : width // 2]
            classes = [count(curves, class_colour(i)) for i in (0, 1)]
            if min(classes) > 200 and len(np.unique(cell.reshape(-1, 3), axis=0)) > 300:
                break
            time.sleep(1.0)
        browser.close()
