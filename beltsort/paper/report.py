"""The report: one HTML file that needs no other."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from beltsort.paper.figures import Picture
from beltsort.paper.files import Numbers, printed_numbers
from beltsort.paper.instances import PAPER
from beltsort.paper.modes import STUDY as MODES
from beltsort.paper.moving import OUTCOMES as MOVING
from beltsort.paper.moving import SETTING, WHERE, held_table
from beltsort.paper.outcomes import LABELS, SCANS, Row, select
from beltsort.paper.outline import Outline
from beltsort.paper.policies import PUBLISHED, RECOMMENDED
from beltsort.paper.printed import TABLES_PRINTED
from beltsort.paper.statistics import ClaimResult, Conclusion
from beltsort.planning.throughput import PURITY
from beltsort.util.extras import extra
from beltsort.util.figure_style import DPI

STYLE = """
body { font: 16px/1.5 serif; max-width: 64rem; margin: 2rem auto; padding: 0 1rem; color: black; }
table { border-collapse: collapse; font: 13px sans-serif; margin: 1rem 0; }
td, th { border-bottom: 1px solid #bbb; padding: 0.2rem 0.6rem; text-align: right; }
td { white-space: nowrap; }
td:first-child, th:first-child { text-align: left; }
img { max-width: 100%; } figure { margin: 1.5rem 0; } pre { font-size: 13px; overflow-x: auto; }
.holds { font-weight: bold; } .fails { font-weight: bold; text-decoration: underline; }
"""
THINNED = (
    "This is the quick run: few batches (two of depth scans), depth scans and offline solutions at three "
    "penalties only, no discount of 0.99, no four positions, fewer settings beyond the paper. It shows that "
    "everything works; for what is true, run it without --quick."
)
THINNED_OWN = "This is the quick run, of few batches; for results, run it without --quick."
PLANNERS_SHOWN = (
    f"Two planners are shown, with {{trials}} trials a plan. {PUBLISHED} is the algorithm of Ye, Somani, Hsu "
    f"and Lee (2017), the paper's planner, which averages over sampled scenarios. {RECOMMENDED} is this "
    "package's default: a search over exact beliefs that descends from it. Where labels are drawn from "
    "tables, both meet the same objects"
)
RECOMMENDED_ONLY = "; depth scans, and the bonus for information, are planned with the recommended one only"
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
    **dict.fromkeys(("bounds", "beyond", "moving"), PAPERS_TABLES),
}
"""What the reader of a figure has to know of where its numbers come from, by its name."""
CONCLUDED = (
    "A claim <em>holds</em> if all of its 95 % confidence interval says so, <em>fails</em> if all of "
    "it says the opposite, and is <em>open</em> otherwise, or from fewer than ten batches. Differences "
    "are taken batch by batch on the same objects; p-values are two-sided and not corrected for the "
    "number of claims."
)
DRAWN = (
    "Objects are drawn from the model's arrival prior, and labels from its tables: what is found holds as "
    "far as these do. A penalty r_min replaces the largest loss of a wrong decision; smaller losses change "
    "in proportion, and bins where no class belongs keep their rewards and count as neither right nor wrong."
)
SHOWN = ("objects", "positions", "r_min", "policy", "batches")
SHOWN_DPI = 150
"""Pixels of the page per inch of a figure."""
SPEED = ("policy", "places_per_minute")
MEANS = ("steps", "positives", "negatives")
MOST_ROWS = 200
"""Rows of the observation tables of a model of one's own that the page shows."""


@dataclass(frozen=True)
class Section:
    """A part of the report with a heading.

    Attributes
    ----------
    name
        Its anchor.
    title
        Its heading.
    body
        HTML, line by line.
    """

    name: str
    title: str
    body: Sequence[str]


def write_report(numbers: Numbers, pictures: Sequence[Picture], folder: Path) -> Path:
    """Write `report.html` into the folder of the pictures and return it."""
    about = numbers.circumstances
    outline = about.outline
    made = _table([{"": name, "this run": value} for name, value in about.rows().items()])
    figures = [_figure(picture, folder, outline) for picture in pictures]
    sections = [
        Section("findings", "Findings", list(main_findings(numbers.findings, outline))),
        _tables_section(numbers),
        Section("figures", "Figures", [*_planners_shown(numbers), *figures]),
        Section("numbers", f"Numbers at r_min = {outline.r_min:g}", list(_numbers(numbers))),
    ]
    if outline.of_the_paper:
        sections.append(Section("printed", "What the paper prints of its robot", [_table(printed_numbers())]))
    if numbers.moving:
        sections.append(Section("moving", "A belt that never stops", list(_moving(numbers))))
    if numbers.optimum:
        bounds = [_table(numbers.optimum)]
        sections.append(Section("optimum", "Bounds of the optimum, and losses against it", bounds))
    sections += [
        Section("claims", "All findings, by condition", claims_section(numbers.findings)),
        Section("made", "How this was made", [made]),
    ]
    path = folder / "report.html"
    path.write_text(_page(outline, sections, thinned=about.quick), encoding="utf-8")
    return path


def _planners_shown(numbers: Numbers) -> list[str]:
    if not select(numbers.rows, policy=PUBLISHED):
        return []
    about = numbers.circumstances
    only = RECOMMENDED_ONLY if about.outline.of_the_paper else ""
    return [f"<p>{escape(PLANNERS_SHOWN.format(trials=about.design.trials))}{only}.</p>"]


def _tables_section(numbers: Numbers) -> Section:
    if numbers.circumstances.outline.of_the_paper:
        body = list(observation_tables(numbers.tables))
        return Section("tables", "Tables I and II: observation tables", body)
    entries = numbers.tables
    known = any(entry["standard_error"] == entry["standard_error"] for entry in entries)
    said = "± is one standard error." if known else "The model has no counts and so no standard errors."
    shown = _table_rows(entries, beside_printed=False)
    if len(shown) > MOST_ROWS:
        said += f" These are the first {MOST_ROWS} of {len(shown)} rows; tables.csv has all."
    body = [f"<p>p(observed | true). {said}</p>", _table(shown[:MOST_ROWS])]
    return Section("tables", "Observation tables, as the paper's Tables I and II", body)


def main_findings(results: Sequence[ClaimResult], outline: Outline) -> Iterable[str]:
    """Yield the findings of the paper's own condition, which is the first, in words, and those on scans.

    Of a model of one's own, yield those of the planners and policies, which are few.
    """
    yield f"<p>{CONCLUDED} {PAPERS_TABLES if outline.of_the_paper else DRAWN}</p>"
    if not outline.of_the_paper:
        judged = [r for r in results if any(r.where.endswith(f", {name}") for name in outline.judged)]
        yield from _by_condition(judged)
        yield "<p>All others are <a href='#claims'>at the end</a>.</p>"
        return
    own = results[0].where
    shown = [result for result in results if result.where == own or result.where.startswith(SCANS)]
    yield from _by_condition(shown)
    yield "<p>All others are <a href='#claims'>at the end</a>.</p>"


def _by_condition(results: Sequence[ClaimResult]) -> Iterable[str]:
    for where in dict.fromkeys(result.where for result in results):
        yield f"<h3>{escape(where)}</h3><ul>"
        for r in results:
            if r.where == where:
                said = f"<span class='{r.conclusion}'>{r.conclusion}</span>"
                yield f"<li>{escape(r.claim)}: {said}. {escape(r.text)}</li>"
        yield "</ul>"


def claims_section(results: Sequence[ClaimResult]) -> list[str]:
    """Return in how many conditions each claim holds, then every result in words, by condition."""
    counts = [
        {"claim": claim}
        | {
            str(conclusion): sum(r.claim == claim and r.conclusion == conclusion for r in results)
            for conclusion in Conclusion
        }
        for claim in dict.fromkeys(result.claim for result in results)
    ]
    return [_table(counts), *_by_condition(results)]


def observation_tables(entries: Sequence[Row]) -> Iterable[str]:
    """Yield Table I and Table II of the simulated cell with standard errors, the paper's numbers beside them.

    Parameters
    ----------
    entries
        From `beltsort.paper.files.table_entries`.
    """
    yield (
        "<p>A simulated table says what the simulator was set to, not how a real camera behaves. "
        f"{CELLS_VIEWPOINTS} {PAPERS_TABLES} Those printed stand beside ours here. "
        "± is one standard error.</p>"
    )
    first = entries[0]["true"]
    one = [entry for entry in entries if (entry["position"], entry["true"]) == (1, first)]
    yield f"<h3>Table I: p(observed | true = {escape(first)}), position 1</h3>"
    yield _table(_table_rows(one))
    yield "<h3>Table II: p(observed | true), both positions, all classes</h3>"
    yield _table(_table_rows(entries))


def _table_rows(entries: Sequence[Row], *, beside_printed: bool = True) -> list[dict[str, str]]:
    """Return a row for each position, true class and viewpoint, a column for each observed label."""
    rows: dict[tuple[int, str, str], dict[str, str]] = {}
    for entry in entries:
        position, true, viewpoint = key = entry["position"], entry["true"], entry["viewpoint"]
        row = rows.setdefault(key, {"position": str(position), "true": true, "viewpoint": viewpoint})
        error = entry["standard_error"]
        row[entry["observed"]] = f"{entry['probability']:.3f}" + (f" ± {error:.3f}" if error == error else "")
        if beside_printed:
            row[f"{entry['observed']}, paper"] = _printed(position, true, viewpoint, entry["observed"])
    classes = list(dict.fromkeys(true for _, true, _ in rows))
    return [rows[key] for key in sorted(rows, key=lambda key: (key[0], classes.index(key[1])))]


def _printed(position: int, true: str, viewpoint: str, observed: str) -> str:
    """Return an entry as the paper prints it; empty if it does not."""
    if (position, true) not in TABLES_PRINTED:
        return ""
    model = PAPER.model
    k, a, b = (
        names.index(name)
        for names, name in zip(
            (model.viewpoints, model.classes, model.labels), (viewpoint, true, observed), strict=True
        )
    )
    return f"{model.p_obs[position - 1, k, a, b]:.1f}"


def _figure(picture: Picture, folder: Path, outline: Outline) -> str:
    """Return a figure with its caption; letters are as large in every one, since all have the same scale."""
    path = folder / f"{picture.name}.png"
    with extra("plot"):
        from PIL import Image
    with Image.open(path) as drawn:
        width = round(drawn.width * SHOWN_DPI / DPI)
    data = b64encode(path.read_bytes()).decode()
    note = NOTES.get(picture.name, "") if outline.of_the_paper else ""
    caption = escape(f"{picture.caption} {note}".strip())
    image = f"<img alt='{caption}' width='{width}' src='data:image/png;base64,{data}'>"
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"


def _numbers(numbers: Numbers) -> Iterable[str]:
    outline, discount = numbers.circumstances.outline, numbers.circumstances.design.discounts[0]
    for title, source in (*((each.title, each.condition) for each in outline.sources), *WITH_MODES):
        rows = select(numbers.rows, discount=discount, r_min=outline.r_min, **source)
        if not rows:
            continue
        rows.sort(
            key=lambda row: (row["objects"], row["policy"] != RECOMMENDED, row["policy"], row["positions"])
        )
        yield f"<h3>{escape(title)}</h3>"
        yield _table([{name: row[name] for name in SHOWN} | _means(row, MEANS, 2) for row in rows])


def _moving(numbers: Numbers) -> Iterable[str]:
    runs, objects = (numbers.moving[0][name] for name in ("batches", "objects"))
    yield f"<p>{escape(SETTING)} {runs} runs of {objects} objects; ± is one standard error.</p>"
    yield _table([{name: row[name] for name in SPEED} | _means(row, MOVING, 3) for row in numbers.moving])
    yield f"<p>Most objects per minute with a purity of at least {PURITY:g}:</p>"
    yield _table(held_table(numbers.moving))
    yield from _by_condition([result for result in numbers.findings if result.where == WHERE])


def _means(row: Row, names: Iterable[str], digits: int) -> dict[str, str]:
    """Return means with their standard errors as text; empty where there is none."""
    found = {name: (row[name], row[f"{name}_standard_error"]) for name in names}
    return {
        name: "" if value is None else f"{value:.{digits}f} ± {error:.{digits}f}"
        for name, (value, error) in found.items()
    }


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    head = "".join(f"<th>{escape(name.replace('_', ' '))}</th>" for name in rows[0])
    lines = ("".join(f"<td>{escape(_cell(value))}</td>" for value in row.values()) for row in rows)
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def _cell(value: Any) -> str:
    if value is None or value != value:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _page(outline: Outline, sections: Sequence[Section], *, thinned: bool) -> str:
    title = "beltsort: the paper again" if outline.of_the_paper else escape(outline.title)
    head = f"<meta charset='utf-8'><title>{title}</title><style>{STYLE}</style>"
    few = THINNED if outline.of_the_paper else THINNED_OWN
    links = "".join(f"<li><a href='#{section.name}'>{escape(section.title)}</a></li>" for section in sections)
    lines = [
        f"<h1>{escape(outline.title)}</h1>",
        *([f"<p><strong>{few}</strong></p>"] if thinned else []),
        *(f"<p>{escape(sentence)}</p>" for sentence in outline.left_out),
        f"<nav><ol>{links}</ol></nav>",
    ]
    for section in sections:
        lines += [f"<h2 id='{section.name}'>{escape(section.title)}</h2>", *section.body]
    body = "\n".join(lines)
    return f"<!DOCTYPE html>\n<html lang='en'><head>{head}</head>\n<body>\n{body}\n</body></html>\n"
