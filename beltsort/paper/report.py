"""The report: one HTML file that needs no other."""

import platform
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from importlib.metadata import version
from pathlib import Path
from typing import Any

import beltsort
from beltsort.paper.curves import SOURCES
from beltsort.paper.design import QUICK, Design
from beltsort.paper.figures import Picture
from beltsort.paper.files import SMOOTHING, printed_numbers
from beltsort.paper.instances import PAPER
from beltsort.paper.labels import LEVEL as LABELS
from beltsort.paper.modes import STUDY as MODES
from beltsort.paper.optimum import losses_table
from beltsort.paper.outcomes import plain_table, select
from beltsort.paper.policies import PUBLISHED, RECOMMENDED
from beltsort.paper.printed import R_MIN, TABLES_PRINTED
from beltsort.paper.run import Results
from beltsort.paper.scans import LEVEL as SCANS
from beltsort.paper.statistics import ClaimResult, Conclusion
from beltsort.sim import CellConfig
from beltsort.tables import Counts, table_one, table_two
from beltsort.util.machine import processor_name, processors

LIBRARIES = ("numpy", "scipy", "matplotlib", "open3d")
STYLE = """
body { font: 16px/1.5 serif; max-width: 64rem; margin: 2rem auto; padding: 0 1rem; color: black; }
table { border-collapse: collapse; font: 13px sans-serif; margin: 1rem 0; }
td, th { border-bottom: 1px solid #bbb; padding: 0.2rem 0.6rem; text-align: right; }
td:first-child, th:first-child { text-align: left; }
img { max-width: 100%; } figure { margin: 1.5rem 0; } pre { font-size: 13px; overflow-x: auto; }
.holds { font-weight: bold; } .fails { font-weight: bold; text-decoration: underline; }
"""
THINNED = (
    "This is the quick run: few batches (two of depth scans), depth scans and offline solutions at three "
    "penalties only, no discount of 0.99, no four positions, fewer settings beyond the paper. It shows that "
    "everything works; for what is true, run it without --quick."
)
PLANNERS_SHOWN = (
    f"Two planners are shown, with {{trials}} trials a plan. {PUBLISHED} is the algorithm of Ye, Somani, Hsu "
    f"and Lee (2017), the paper's planner, which averages over sampled scenarios. {RECOMMENDED} is this "
    "package's default: a search over exact beliefs that descends from it. Where labels are drawn from "
    "tables, both meet the same objects; depth scans, and the bonus for information, are planned with the "
    "recommended one only."
)
WITH_MODES = (
    ("labels from the cell's tables with modes", {"level": LABELS, "study": MODES}),
    ("depth scans of the cell, with modes and confidence levels", {"level": SCANS, "study": MODES}),
)
PAPERS_TABLES = (
    f"Of the {PAPER.model.positions * len(PAPER.model.classes)} blocks (a position and a class) of what is "
    f"called the paper's tables here, the paper prints {len(TABLES_PRINTED)}; the others are ours, of "
    "similar accuracy."
)
CELLS_VIEWPOINTS = "p1, p2 and p3 are the simulated cell's viewpoints, not those of the paper."
OTHER_VIEWPOINTS = "The simulated cell's p1, p2 and p3 are not those of the paper's tables."
NOTES = {
    "figure_1_sphere": CELLS_VIEWPOINTS,
    "figure_1_clouds": "Classes are named as the paper's; their shapes are ours.",
    "figure_2_propagation": PAPERS_TABLES,
    "figure_3_run": CELLS_VIEWPOINTS,
    **dict.fromkeys(
        ("figure_4_one_position", "figure_5_two_positions", "figure_6_steps", "figure_7_one_against_two"),
        f"{PAPERS_TABLES} {OTHER_VIEWPOINTS}",
    ),
    **dict.fromkeys(("bounds", "beyond"), PAPERS_TABLES),
}
"""What the reader of a figure has to know of where its numbers come from, by its name."""
SHOWN = ("objects", "positions", "r_min", "policy", "batches")
MEANS = ("steps", "positives", "negatives")


@dataclass(frozen=True)
class Circumstances:
    """How the results of a report were made.

    Attributes
    ----------
    command
        The command line or function call.
    seed
        Seed of all experiments.
    design
        What was run.
    """

    command: str
    seed: int
    design: Design

    def facts(self, seconds: Mapping[str, float]) -> dict[str, str]:
        """Return command, seed, versions, machine and times as text, by name."""
        return {
            "made by": self.command,
            "seed": str(self.seed),
            "versions": ", ".join(
                [f"beltsort {beltsort.__version__}", f"Python {platform.python_version()}"]
                + [f"{name} {version(name)}" for name in LIBRARIES]
            ),
            "machine": f"{processor_name()}, {processors()} processors, {platform.platform()}",
            "finished": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
            "seconds, this time": ", ".join(f"{name} {value:.0f}" for name, value in seconds.items()),
        }


def write_report(
    results: Results, counts: Counts, pictures: Sequence[Picture], of: Circumstances, folder: Path
) -> Path:
    """Write `report.html` into the folder of the pictures and return it."""
    facts = of.facts(results.seconds)
    body = [
        "<h1>Sorting objects from a conveyor belt: the paper's experiments again</h1>",
        *([f"<p><strong>{THINNED}</strong></p>"] if of.design == QUICK else []),
        _table([{"": name, "this run": value} for name, value in facts.items()]),
        "<h2>Tables I and II: the simulated cell's observation tables</h2>",
        "<p>A simulated table says what the simulator was set to, not how a real camera behaves. "
        f"{CELLS_VIEWPOINTS} {PAPERS_TABLES}</p>",
        *(f"<pre>{escape(text)}</pre>" for text in _observation_tables(counts)),
        "<h2>Figures</h2>",
        f"<p>{escape(PLANNERS_SHOWN.format(trials=of.design.trials))}</p>",
        *(_figure(picture, folder) for picture in pictures),
        f"<h2>Numbers at r_min = {R_MIN:g}</h2>",
        *_numbers(results, of.design.discounts[0]),
        "<h2>What the paper prints of its robot</h2>",
        _table(printed_numbers()),
        "<h2>Bounds of the optimum, and losses against it</h2>",
        _table(losses_table(results.optimum)),
        *claims_section(results.claims()),
    ]
    path = folder / "report.html"
    path.write_text(_page("\n".join(body)), encoding="utf-8")
    return path


def claims_section(results: Sequence[ClaimResult]) -> list[str]:
    """Return in how many conditions each claim holds, then every result in words, by condition."""
    by_condition: dict[str, list[ClaimResult]] = {}
    for result in results:
        by_condition.setdefault(result.where, []).append(result)
    counts = [
        {"claim": claim}
        | {
            str(conclusion): sum(r.claim == claim and r.conclusion == conclusion for r in results)
            for conclusion in Conclusion
        }
        for claim in dict.fromkeys(result.claim for result in results)
    ]
    lines = [
        "<h2 id='findings'>Findings</h2>",
        "<p>A claim <em>holds</em> if all of its 95 % confidence interval says so, <em>fails</em> if all of "
        "it says the opposite, and is <em>open</em> otherwise, or from fewer than ten batches. Differences "
        "are taken batch by batch on the same objects; p-values are two-sided and not corrected for the "
        f"number of claims. {PAPERS_TABLES}</p>",
        _table(counts),
    ]
    for where, found in by_condition.items():
        lines.append(f"<h3>{escape(where)}</h3><ul>")
        lines += [
            f"<li>{escape(r.claim)}: <span class='{r.conclusion}'>{r.conclusion}</span>. "
            f"{escape(r.text)}</li>"
            for r in found
        ]
        lines.append("</ul>")
    return lines


def _observation_tables(counts: Counts) -> list[str]:
    config = CellConfig()
    names = [viewpoint.name for viewpoint in config.viewpoints]
    p_obs = counts.probabilities(SMOOTHING)
    return [table_one(p_obs, config.classes, names, true=0), table_two(p_obs, config.classes, names)]


def _figure(picture: Picture, folder: Path) -> str:
    data = b64encode((folder / f"{picture.name}.png").read_bytes()).decode()
    caption = escape(f"{picture.caption} {NOTES.get(picture.name, '')}".strip())
    image = f"<img alt='{caption}' src='data:image/png;base64,{data}'>"
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"


def _numbers(results: Results, discount: float) -> Iterable[str]:
    for title, source in (*SOURCES, *WITH_MODES):
        rows = select(results.rows, discount=discount, r_min=R_MIN, **source)
        if not rows:
            continue
        rows.sort(
            key=lambda row: (row["objects"], row["policy"] != RECOMMENDED, row["policy"], row["positions"])
        )
        yield f"<h3>{escape(title)}</h3>"
        yield _table(
            [
                {name: row[name] for name in SHOWN}
                | {name: f"{row[name]:.2f} ± {row[f'{name}_standard_error']:.2f}" for name in MEANS}
                for row in plain_table(rows)
            ]
        )


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    head = "".join(f"<th>{escape(name.replace('_', ' '))}</th>" for name in rows[0])
    lines = ("".join(f"<td>{escape(_cell(value))}</td>" for value in row.values()) for row in rows)
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def _cell(value: Any) -> str:
    if value is None or value != value:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _page(body: str) -> str:
    head = f"<meta charset='utf-8'><title>beltsort: the paper again</title><style>{STYLE}</style>"
    return f"<!DOCTYPE html>\n<html lang='en'><head>{head}</head>\n<body>\n{body}\n</body></html>\n"
