"""Everything is written; the numbers depend on the seed alone, whatever happens to the processes."""

import html
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text

from beltsort import paper
from beltsort.cli import main
from beltsort.cli.reproduce import show_text
from beltsort.paper import Reproduction, printed, redraw, run_experiments
from beltsort.paper.beyond import BONUS
from beltsort.paper.files import REPRODUCIBLE, Numbers
from beltsort.paper.policies import PLANNERS, PUBLISHED, RECOMMENDED
from beltsort.paper.printed import TABLES_PRINTED
from beltsort.paper.report import observation_tables
from beltsort.paper.run import STORE
from beltsort.sim.prepare import Prepared
from beltsort.util.figure_style import COLUMN, LETTERS
from tests.waiting import wait_until

from .conftest import Commanded
from .tiny import SEED, TINY

pytestmark = pytest.mark.process

ROOT = Path(__file__).parents[2]
FIGURES = {
    "figure_1_sphere", "figure_1_clouds", "figure_2_propagation", "figure_3_run", "figure_4_one_position",
    "figure_5_two_positions", "figure_6_steps", "figure_7_one_against_two", "bounds", "beyond", "moving",
}  # fmt: skip


def test_every_figure_is_there_and_shows_something(reproduction: Reproduction, folder: Path) -> None:
    from matplotlib.image import imread

    assert {picture.name for picture in reproduction.pictures} == FIGURES
    for name in FIGURES:
        pixels = imread(folder / f"{name}.png")[..., :3]
        assert np.mean(pixels.min(axis=-1) < 0.9) > 0.01, name
        drawing = (folder / f"{name}.svg").read_text()
        assert drawing.count("<path") > 20, name


def test_axes_have_names_and_the_papers_numbers_are_marked(reproduction: Reproduction, folder: Path) -> None:
    texts = re.findall(r"<!-- *(.*?) *-->", (folder / "figure_6_steps.svg").read_text())
    assert texts.count("steps for ten objects") == 3  # one for each row of panels, which share it
    assert {"paper's robot, one position", "paper's robot, two positions"} <= set(texts)
    assert {*PLANNERS, "filled: one position", "hollow: two positions"} <= set(texts)


def test_the_report_needs_no_other_file(reproduction: Reproduction) -> None:
    page = reproduction.report.read_text()
    assert not re.search(r"(?:src|href)=['\"](?!data:|#)", page)
    assert page.count("data:image/png;base64,") == len(FIGURES)
    for said in ("beltsort 0", "processors", "p(observed | true = elongated), position 1"):
        assert said in page
    assert page.index("Findings</h2>") < page.index("<figure>"), "the findings open it"


def test_the_contents_lead_to_every_section(reproduction: Reproduction) -> None:
    page = reproduction.report.read_text()
    linked = re.findall(r"<li><a href='#(.*?)'>", page)
    assert linked == re.findall(r"<h2 id='(.*?)'>", page)
    assert linked[0] == "findings"


def test_the_papers_numbers_stand_beside_ours_where_it_prints_them(reproduction: Reproduction) -> None:
    rows = list(observation_tables(reproduction.numbers.tables))[-1].split("<tr>")
    (own,) = [row for row in rows if "<td>1</td><td>elongated</td><td>p1</td>" in row]
    assert re.findall(r"<td>(\d\.\d)</td>", own) == ["0.6", "0.2", "0.0", "0.2"]
    assert len(re.findall(r"<td>\d\.\d{3} ± \d\.\d{3}</td>", own)) == 4
    shown = sum(bool(re.search(r"<td>\d\.\d</td>", row)) for row in rows)
    assert shown == 3 * len(TABLES_PRINTED)


def test_figures_and_report_are_drawn_again_from_the_files(
    prepared: Prepared, reproduction: Reproduction, folder: Path, tmp_path: Path
) -> None:
    again = redraw(prepared, folder, tmp_path)
    said, before = ([r.plain() for r in each.numbers.findings] for each in (again, reproduction))
    assert said == before
    assert again.numbers.circumstances == reproduction.numbers.circumstances
    for name in FIGURES:
        for ending in (".png", ".svg", ".pdf"):
            assert (tmp_path / f"{name}{ending}").read_bytes() == (folder / f"{name}{ending}").read_bytes()
    assert again.report.read_bytes() == reproduction.report.read_bytes()


def test_redrawing_needs_a_reproduction(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--from", str(tmp_path)]) == 2
    assert "expected a folder that `beltsort reproduce` has written" in capsys.readouterr().err


def test_panels_that_are_compared_share_their_scales_and_points_are_where_they_belong(
    reproduction: Reproduction,
) -> None:
    rows = reproduction.numbers.rows
    for figure in (paper.accuracy_figure(rows, 2, 0.95), paper.steps_figure(rows, 0.95)):
        panels = [panel for panel in figure.axes if panel.get_xlabel() or panel.lines]
        assert len({panel.get_ylim() for panel in panels}) == len({panel.get_xlim() for panel in panels}) == 1
        assert figure.get_figwidth() == COLUMN
        texts = [text for text in figure.findobj(Text) if text.get_text()]
        assert min(float(text.get_fontsize()) for text in texts) >= LETTERS
        penalties = {row["r_min"] for row in rows} | set(printed.STEPS)
        drawn = {x for panel in panels for line in panel.lines for x in np.asarray(line.get_xdata()).tolist()}
        assert drawn <= penalties


def test_the_report_says_which_tables_and_viewpoints_are_not_the_papers(reproduction: Reproduction) -> None:
    page = reproduction.report.read_text()
    names = [picture.name for picture in reproduction.pictures]
    captions = dict(zip(names, re.findall(r"<figcaption>(.*?)</figcaption>", page), strict=True))
    printed = "the paper prints 3; the others are ours"
    of_the_model = {name for name, caption in captions.items() if printed in html.unescape(caption)}
    assert of_the_model == set(FIGURES) - {"figure_1_sphere", "figure_1_clouds", "figure_3_run"}
    of_the_cell = {name for name, caption in captions.items() if "p1, p2 and p3" in caption}
    assert of_the_cell == {name for name in FIGURES if name.startswith("figure")} - {
        "figure_1_clouds",
        "figure_2_propagation",
    }


def test_rows_are_whole(reproduction: Reproduction) -> None:
    results = reproduction.results
    for row in [*results.rows, *results.beyond]:
        assert np.add(row["positives"], row["negatives"]).max() <= 10
        assert min(row["steps"]) >= 10
        returns = [
            10 * right - row["r_min"] * wrong - (steps - right - wrong)
            for right, wrong, steps in zip(row["positives"], row["negatives"], row["steps"], strict=True)
        ]
        np.testing.assert_allclose(row["returns"], returns)
    for solved in results.optimum:
        assert solved["lower"] <= solved["upper"]
        assert min(map(min, solved["losses"].values())) >= 0.0
    assert {row["parameter"] is None for row in paper.select(results.labels, policy="threshold")} == {False}


def conditions_of(rows: list[dict[str, Any]], policy: str) -> set[tuple[Any, ...]]:
    names = ("study", "setting", "instance", "objects", "positions", "discount", "r_min")
    return {(*(row[name] for name in names), len(row["steps"])) for row in rows if row["policy"] == policy}


def test_both_planners_are_in_every_experiment_from_tables(reproduction: Reproduction, folder: Path) -> None:
    results = reproduction.results
    without_bonus = [row for row in results.beyond if row["study"] != BONUS]
    for rows in (results.labels, without_bonus):
        assert conditions_of(rows, PUBLISHED) == conditions_of(rows, RECOMMENDED) != set()
    bonuses = paper.select(results.beyond, study=BONUS)
    assert {row["policy"] for row in bonuses} == {RECOMMENDED}, "the published one cannot plan with a bonus"
    assert all(set(PLANNERS) < set(solved["losses"]) for solved in results.optimum)
    for name in ("labels.csv", "beyond.csv"):
        assert f",{PUBLISHED}," in (folder / name).read_text()
    header = (folder / "optimum.csv").read_text().splitlines()[0]
    assert {"DESPOT_recommended_loss", "DESPOT_as_published_loss"} <= set(header.split(","))
    for figure in ("figure_4_one_position", "figure_7_one_against_two", "bounds", "beyond"):
        drawing = (folder / f"{figure}.svg").read_text()
        assert all(f"<!-- {planner}" in drawing for planner in PLANNERS), figure
    page = reproduction.report.read_text()
    assert f"<td>{PUBLISHED}</td>" in page


def test_claims_are_of_each_planner_and_of_one_against_the_other(reproduction: Reproduction) -> None:
    found = reproduction.results.claims()
    for claim in ("two positions need fewer steps", "equal accuracy with two positions"):
        where = [result.where for result in found if result.claim == claim and "tables (" in result.where]
        by_planner = [
            {text.removesuffix(f", {planner}") for text in where if planner in text} for planner in PLANNERS
        ]
        assert by_planner[0] == by_planner[1] != set()
    (solved,) = paper.select(reproduction.results.optimum, positions=2, r_min=50.0)
    (result,) = [r for r in found if r.claim == f"{RECOMMENDED} beats {PUBLISHED}, r_min = 50, positions: 2"]
    lost = {planner: np.mean(solved["losses"][planner]) for planner in PLANNERS}
    assert result.estimate.value == pytest.approx(lost[PUBLISHED] - lost[RECOMMENDED])


def halve(store: Path) -> int:
    """Forget every second of the finished points; return how many are left."""
    with closing(sqlite3.connect(store)) as database, database:
        database.execute("DELETE FROM points WHERE rowid % 2 = 0")
        return int(database.execute("SELECT count(*) FROM points").fetchone()[0])


def rows_in(store: Path) -> int:
    with closing(sqlite3.connect(store)) as database:
        return int(database.execute("SELECT count(*) FROM points").fetchone()[0])


def test_killed_resumed_and_on_two_processes_the_numbers_are_the_same(
    prepared: Prepared, reproduction: Reproduction, folder: Path, tmp_path: Path
) -> None:
    cell, model = reproduction.results.cell, tmp_path / "model.json"
    assert cell is not None
    cell.instance.model.save(model)
    shutil.copytree(folder / STORE, tmp_path / STORE)
    left = {stage: halve(tmp_path / STORE / stage / "rows.sqlite") for stage in ("labels", "scans")}
    command = [sys.executable, "-m", "tests.paper.tiny", str(model), str(cell.database), str(tmp_path)]
    with subprocess.Popen(command, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}) as killed:
        scans = tmp_path / STORE / "scans" / "rows.sqlite"
        wait_until(
            lambda: killed.poll() is not None or rows_in(scans) > left["scans"],
            "a row of scans",
            timeout=250.0,
        )
        killed.send_signal(signal.SIGKILL)
    assert killed.returncode == -signal.SIGKILL
    first: dict[str, tuple[int, int]] = {}
    resumed = run_experiments(
        cell, tmp_path, TINY, seed=SEED, workers=2,
        stage=lambda name: lambda done, total: first.setdefault(name, (done, total)) and None,
    )  # fmt: skip
    assert first["labels"][0] == first["labels"][1], "what was finished is not run again"
    assert left["scans"] < first["scans"][0] < first["scans"][1]
    about = reproduction.numbers.circumstances
    Numbers.of(resumed, prepared.counts, about).write(tmp_path)
    for name in REPRODUCIBLE:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name


def test_another_seed_gives_other_numbers() -> None:
    points = [paper.label_point(TINY, seed, paper.PAPER.model, paper.FOUR, batches=20) for seed in (0, 1)]
    one, other = (paper.simulate_labels(point)["steps"] for point in points)
    assert one != other
    assert one == paper.simulate_labels(points[0])["steps"]


def test_the_command_tells_what_it_found(
    commanded: Commanded, reproduction: Reproduction, capsys: pytest.CaptureFixture[str]
) -> None:
    told = commanded.printed
    assert told["findings"] == [result.plain() for result in reproduction.results.claims()]
    assert told["findings"][0]["claim"] == "two positions need fewer steps"
    assert "beltsort reproduce --quick" in Path(told["report"]).read_text()
    show_text(reproduction)
    assert "two positions need fewer steps" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "complaint"), [(["--seed", "-1"], "seed is -1"), (["--workers", "0"], "workers is 0")]
)
def test_bad_arguments_are_refused_before_anything_is_done(
    arguments: list[str], complaint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["reproduce", "-o", str(tmp_path / "new"), *arguments]) == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
