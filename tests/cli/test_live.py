"""The live view on a terminal keeps to its size, whatever the run."""

import io

import numpy as np
import pytest
from rich.console import Console

import beltsort
from beltsort.cli.live import LiveView
from beltsort.sorting.entries import AnyContent, Decided, Planned, Resumed, Scanned, Skipped, Started
from beltsort.sorting.journal import Entry


def model_of(positions: int, classes: int) -> beltsort.SortingModel:
    names = [f"class number {i}" for i in range(classes)]
    table = np.full((positions, 2, classes, classes), 0.2 / max(1, classes - 1))
    table[..., range(classes), range(classes)] = 0.8 if classes > 1 else 1.0
    return beltsort.SortingModel(names, ["from the left", "from the right"], table)


def course(model: beltsort.SortingModel, objects: int) -> list[AnyContent]:
    """Return entries of a run that scans, plans and decides about every object, or finds its cup empty."""
    belief = beltsort.Belief(model).probabilities.tolist()
    positions = model.positions
    values = [{"move": 0, "value": 123.45}, {"decide": 0, "value": -50.0}]
    entries: list[AnyContent] = [Started(run="a", objects=objects, model=model.to_json())]
    for index in range(objects):
        scan = Scanned(
            viewpoint=1,
            labels=[0] * positions,
            empty=[False] * positions,
            findings=["object"] * positions,
            dropped=[],
            belief=belief,
            last_labels=[],
        )
        plan = Planned({"decide": 0}, values, lower=0.0, upper=1.0, trials=1, seconds=0.1)
        decision = Decided(label=index % len(model.bins), bin=0, belief=0.9, looks=3, forced=None)
        entries += [scan, plan, Skipped([0, 1], decided=False) if index % 7 == 6 else decision]
    return entries


def shown(model: beltsort.SortingModel, objects: int, width: int, height: int) -> list[str]:
    """Return the lines of the view after a run."""
    console = Console(file=io.StringIO(), width=width, height=height, force_terminal=True)
    view = LiveView(console)
    for number, content in enumerate(course(model, objects), start=1):
        view(Entry(number, "2026-01-01T00:00:00+00:00", number, content))
    return ["".join(part.text for part in line).rstrip() for line in console.render_lines(view)]


@pytest.mark.parametrize("size", [(80, 24), (200, 60), (60, 16)])
@pytest.mark.parametrize(("positions", "classes"), [(1, 2), (2, 4), (4, 4), (4, 20), (8, 12)])
def test_it_fits_the_terminal(positions: int, classes: int, size: tuple[int, int]) -> None:
    width, height = size
    lines = shown(model_of(positions, classes), 500, width, height)
    assert len(lines) < height  # one is left for the cursor
    assert max(map(len, lines)) <= width


def test_four_positions_and_five_hundred_objects_on_a_small_terminal() -> None:
    text = "\n".join(shown(model_of(4, 4), 500, 80, 24))
    assert "sorted 429 of 500, 71 empty: " in text
    for heading in ("belt end", "position 2", "position 3", "position 4"):
        assert heading in text
    assert text.count("░ 0.25") == 4 * 4


def test_the_likeliest_classes_are_shown_where_not_all_fit() -> None:
    model = model_of(2, 40)
    console = Console(file=io.StringIO(), width=80, height=24, force_terminal=True)
    view = LiveView(console)
    belief = [[0.61, *[0.01] * 39], [0.01] * 39 + [0.61]]
    start, scan, *_ = course(model, 1)
    assert isinstance(scan, Scanned)
    view(Entry(1, "", 0, start))
    view(Entry(2, "", 0, Scanned(**{**scan.__dict__, "belief": [belief[1], belief[0]]})))
    text = "\n".join("".join(part.text for part in line) for line in console.render_lines(view))
    assert "class number 39" in text
    assert "0.61" in text


def test_a_resumed_run_has_its_number_of_objects() -> None:
    console = Console(file=io.StringIO(), width=80, height=24)
    view = LiveView(console)
    view(Entry(9, "", 3, Resumed(objects=12, model=model_of(2, 2).to_json())))
    lines = console.render_lines(view)
    assert "sorted 0 of 12" in "".join(part.text for line in lines for part in line)
