"""Comparisons as figures, data frames and LaTeX."""

import builtins
import math
import subprocess
import sys
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.container import ErrorbarContainer

from beltsort import (
    ArgumentError,
    Comparison,
    OneObject,
    Policy,
    SortingModel,
    Threshold,
    compare,
    evaluate,
)
from beltsort.errors import MissingExtraError
from beltsort.planning.difference import Difference

mpl.use("Agg")


@pytest.fixture(scope="module")
def compared(paper: SortingModel) -> Comparison:
    policies = {
        "base_line": Threshold(paper, 0.94),
        "hasty": Threshold(paper, 0.7),
        "twin & co": Threshold(paper, 0.94),
    }
    return compare(paper, policies, batches=50, seed=3)


def test_intervals() -> None:
    lower, upper = Difference(1.0, 0.5).interval
    assert (lower, upper) == pytest.approx((1 - 0.5 * 1.959964, 1 + 0.5 * 1.959964))
    assert Difference(1.0, 0.5).significant
    assert Difference(-1.0, 0.5).significant
    assert not Difference(1.0, 0.6).significant
    assert not Difference(1.0, math.nan).significant
    assert not Difference(0.0, 0.0).significant


def test_plots_show_paired_differences_with_intervals(compared: Comparison) -> None:
    axes = compared.plot("steps")
    assert [label.get_text() for label in axes.get_yticklabels()] == ["hasty", "twin & co"]
    assert axes.get_title() == "Steps"
    assert "minus base_line, per batch of 10" in axes.get_xlabel()
    for row, (container, name) in enumerate(zip(axes.containers, ("hasty", "twin & co"), strict=True)):
        assert isinstance(container, ErrorbarContainer)
        point, _, (bar,) = container.lines
        difference = compared.difference(name, "steps")
        assert np.asarray(point.get_xydata()).tolist() == [[difference.mean, row]]
        assert bar.get_segments()[0][:, 0] == pytest.approx(difference.interval)
        assert (point.get_markerfacecolor() != "white") == difference.significant
    axes.figure.canvas.draw()


def test_plots_on_given_axes(compared: Comparison) -> None:
    from matplotlib.figure import Figure

    panel = Figure().add_subplot()
    assert compared.plot(ax=panel) is panel
    assert panel.get_title() == "Expected discounted returns"


def test_plots_of_other_metrics(paper: SortingModel) -> None:
    policies: dict[str, Policy] = {"a": Threshold(paper, 0.9), "b": OneObject(paper)}
    drawn = compare(paper, policies, batches=3, true_classes=["mushroom"])
    assert drawn.plot().get_title() == "Discounted returns"
    assert compare(paper, policies, batches=3, metrics=["correct"]).plot().get_title() == "Correct"


def test_frames(compared: Comparison) -> None:
    frame = compared.to_pandas()
    assert frame.index.names == ["policy", "metric"]
    assert len(frame) == 3 * len(compared.metrics)
    row = frame.loc[("hasty", "steps")]
    difference = compared.difference("hasty", "steps")
    assert row["mean"] == compared.summary()["hasty"]["steps"]["mean"]
    assert (row["difference"], row["difference_standard_error"], row["z"]) == (
        difference.mean,
        difference.standard_error,
        difference.z,
    )
    assert frame.loc["base_line"][["difference", "z"]].isna().all(axis=None)


def test_frames_of_evaluations(paper: SortingModel) -> None:
    result = evaluate(paper, Threshold(paper, 0.9), batches=4)
    frame = result.to_pandas()
    assert list(frame.columns) == list(result.summary())
    assert frame.index.name == "batch"
    assert np.array_equal(frame["returns"], result.returns)
    assert frame["steps"].dtype == np.uint64


def test_without_pandas_the_error_says_what_to_type(
    compared: Comparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def without_pandas(name: str, *arguments: Any, **keywords: Any) -> Any:
        if name == "pandas":
            raise ModuleNotFoundError("No module named 'pandas'", name="pandas")
        return real(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", without_pandas)
    for make in (compared.to_pandas, compared.evaluations["hasty"].to_pandas):
        with pytest.raises(
            MissingExtraError, match=r"pandas is not installed; pip install 'beltsort\[pandas\]'$"
        ):
            make()


def test_latex(compared: Comparison) -> None:
    table = compared.to_latex(["steps", "correct"], label="tab:policies")
    lines = [line.strip() for line in table.splitlines()]
    assert lines[0] == r"\begin{table}"
    assert lines[-1] == r"\end{table}"
    assert r"\label{tab:policies}" in lines
    assert r"\begin{tabular}{lrr}" in lines
    header, *rows = [line for line in lines if line.endswith(r"\\")]
    assert header == r"& steps & correct \\"
    summary = compared.summary()
    for row, (name, escaped) in zip(
        rows, {"base_line": r"base\_line", "hasty": "hasty", "twin & co": r"twin \& co"}.items(), strict=True
    ):
        cells = row.removesuffix(r" \\").split(" & ")
        assert cells[0] == escaped
        steps = summary[name]["steps"]
        number = rf"${steps['mean']:.3f} \pm {steps['standard_error']:.3f}$"
        assert cells[1] == number + (r"\rlap{$^{*}$}" if name == "hasty" else "")
    for rule in ("toprule", "midrule", "bottomrule"):
        assert f"\\{rule}" in lines


def test_the_latex_caption_says_what_is_significant(compared: Comparison) -> None:
    (caption,) = [line for line in compared.to_latex().splitlines() if r"\caption" in line]
    assert r"Mean $\pm$ standard error per batch of 10 objects, over 50 batches." in caption
    assert r"difference from base\_line in the same batches that is significant at the 5\,\% level" in caption
    assert "two-sided, paired by batch" in caption
    assert "not corrected for multiple comparisons" in caption


def test_unknown_metrics_are_refused(compared: Comparison) -> None:
    for call in (lambda: compared.plot("speed"), lambda: compared.to_latex(["speed"])):
        with pytest.raises(ArgumentError, match=r"'speed'.*steps"):
            call()


@pytest.mark.process
def test_comparing_imports_neither_matplotlib_nor_pandas() -> None:
    code = (
        "import sys, beltsort; from beltsort.models import paper; m = paper();"
        "c = beltsort.compare(m, {'a': beltsort.Threshold(m, 0.9), 'b': beltsort.OneObject(m)}, batches=2);"
        "repr(c), c._repr_html_(), c.to_latex();"
        "print({'matplotlib', 'pandas', 'scipy'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
