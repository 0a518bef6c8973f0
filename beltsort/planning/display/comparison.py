"""Comparisons as tables: plain text, HTML and LaTeX."""

from collections.abc import Mapping, Sequence

from beltsort.planning.difference import CONFIDENCE, PairedStatistics
from beltsort.util.html import box, caption, table
from beltsort.util.text import text_table

LATEX_SPECIAL = {character: f"\\{character}" for character in "&%$#_{}"} | {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}


def comparison_text(found: PairedStatistics) -> str:
    """Format means and paired differences as plain text, a row per metric."""
    means_title, differences_title = _titles(found)
    return "\n".join(
        [
            f"{means_title}:",
            text_table([["", *found.summary], *_means(found)]),
            f"{differences_title}:",
            text_table([["", *found.differences], *_differences(found)]),
        ]
    )


def comparison_html(found: PairedStatistics, remarks: Sequence[str] = ()) -> str:
    """Return means and paired differences as HTML, and remarks of plain text, preformatted."""
    means_title, differences_title = _titles(found)
    return box(
        "Comparison",
        caption(means_title),
        table(_means(found), header=["", *found.summary]),
        caption(differences_title),
        table(_differences(found), header=["", *found.differences]),
        preformatted="\n\n".join(remarks),
    )


def comparison_latex(found: PairedStatistics, metrics: Sequence[str], label: str | None) -> str:
    """Return a LaTeX table for the package booktabs, a row per policy and a column per metric."""
    rows = [
        [latex_escaped(name), *(_latex_cell(found, name, metric) for metric in metrics)]
        for name in found.summary
    ]
    header = ["", *(latex_escaped(metric.replace("_", " ")) for metric in metrics)]
    return "\n".join(
        [
            r"\begin{table}",
            r"  \centering",
            rf"  \caption{{{_latex_caption(found)}}}",
            *([rf"  \label{{{label}}}"] if label else []),
            rf"  \begin{{tabular}}{{l{'r' * len(metrics)}}}",
            r"    \toprule",
            f"    {' & '.join(header)} \\\\",
            r"    \midrule",
            *(f"    {' & '.join(row)} \\\\" for row in rows),
            r"    \bottomrule",
            r"  \end{tabular}",
            r"\end{table}",
        ]
    )


def latex_escaped(text: str) -> str:
    r"""Return text with the characters escaped that LaTeX would interpret.

    Examples
    --------
    >>> print(latex_escaped("threshold_0.94 & more"))
    threshold\_0.94 \& more
    """
    return "".join(LATEX_SPECIAL.get(character, character) for character in text)


def _titles(found: PairedStatistics) -> tuple[str, str]:
    return (
        f"Per batch of {found.batch_size}, mean ± standard error over {found.batches}",
        f"Minus {found.baseline} in the same batches, mean ± standard error (z)",
    )


def _means(found: PairedStatistics) -> list[list[str]]:
    return _rows(
        found.metrics,
        {
            name: {metric: f"{s['mean']:.3f} ± {s['standard_error']:.3f}" for metric, s in summary.items()}
            for name, summary in found.summary.items()
        },
    )


def _differences(found: PairedStatistics) -> list[list[str]]:
    return _rows(
        found.metrics,
        {
            name: {
                metric: f"{d.mean:+.3f} ± {d.standard_error:.3f} ({d.z:+.1f})"
                for metric, d in differences.items()
            }
            for name, differences in found.differences.items()
        },
    )


def _rows(metrics: Sequence[str], cells: Mapping[str, Mapping[str, str]]) -> list[list[str]]:
    """Return a row per metric, with a cell per policy."""
    return [[metric.replace("_", " "), *(column[metric] for column in cells.values())] for metric in metrics]


def _latex_cell(found: PairedStatistics, name: str, metric: str) -> str:
    statistics = found.summary[name][metric]
    different = name != found.baseline and found.differences[name][metric].significant
    # The star takes no room, so that the numbers of a column stay aligned.
    star = r"\rlap{$^{*}$}" if different else ""
    return rf"${statistics['mean']:.3f} \pm {statistics['standard_error']:.3f}${star}"


def _latex_caption(found: PairedStatistics) -> str:
    significance = (
        rf"An asterisk marks a difference from {latex_escaped(found.baseline)} in the same batches that is "
        rf"significant at the {100 * (1 - CONFIDENCE):.0f}\,\% level (two-sided, paired by batch, normal "
        "approximation, not corrected for multiple comparisons)."
    )
    return (
        rf"Mean $\pm$ standard error per batch of {found.batch_size} objects, over {found.batches} batches. "
        f"{significance}"
    )
