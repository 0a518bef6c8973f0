"""The code blocks of the documentation are true: each page is run from top to bottom."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.sim import prepare
from tests.docs.pages import LANGUAGES, ROOT, PageRun, blocks_of

TUTORIAL = sorted((ROOT / "docs" / "tutorial").glob("[0-9]*.md"))
PAGES = sorted(path for path in (ROOT / "docs").glob("*.md") if blocks_of(path))
EVERY_PAGE = [*TUTORIAL, *PAGES]


def name_of(page: Path) -> str:
    return page.stem


@pytest.mark.parametrize("page", EVERY_PAGE, ids=name_of)
def test_every_block_has_a_language(page: Path) -> None:
    wrong = [
        f"line {block.line}: {block.language!r}"
        for block in blocks_of(page)
        if block.language not in LANGUAGES
    ]
    assert not wrong, f"expected one of {LANGUAGES} (tests/docs/pages.py)"


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what a reader would have: a model, a classifier, clouds of two classes, the examples."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "classifier.npz").write_bytes((prepare.PACKAGED / "classifier.npz").read_bytes())
    beltsort.models.paper().save(folder / "model.json")
    shutil.copytree(ROOT / "examples", folder / "examples")
    generator = np.random.default_rng(0)
    for name, height in {"flat": 0.05, "tall": 0.1}.items():
        (folder / "clouds" / name).mkdir(parents=True)
        for number in range(3):
            points = generator.random((500, 3)) * [0.05, 0.05, height]
            np.savetxt(folder / "clouds" / name / f"{number}.xyz", points)
    return folder


@pytest.mark.process
@pytest.mark.slow
def test_tutorial(tmp_path: Path) -> None:
    """Its pages use one folder."""
    for page in TUTORIAL:
        PageRun(page, tmp_path).run()


@pytest.mark.process
@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_page(page: Path, made: Path, tmp_path: Path) -> None:
    folder = tmp_path / "page"
    shutil.copytree(made, folder)
    PageRun(page, folder).run()


def test_few_blocks_are_not_run() -> None:
    blocks = [block for page in EVERY_PAGE for block in blocks_of(page)]
    commands = [block for block in blocks if block.language in ("sh", "python")]
    assert sum(not block.runs for block in commands) <= 0.4 * len(commands)
