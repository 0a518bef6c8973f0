"""Small HTML tables that can be read on light and dark pages, without scripts or style sheets."""

from collections.abc import Sequence
from html import escape

# Everything but the shade takes the colours of the page, also where these are not inherited by tables.
TABLE = "border-collapse:collapse;margin:0.3em 0;color:inherit;font-size:inherit"
CELL = "padding:0.15em 0.7em;text-align:{align};vertical-align:top;white-space:{wrap};{look}"
SHADE = "background:rgba(0,114,178,{alpha:.2f});"
DARKEST = 0.55  # of a shade; text in the page's colour can be read on it, be it black or white


def table(
    rows: Sequence[Sequence[str]],
    *,
    header: Sequence[str] = (),
    numbers: bool = True,
    shades: Sequence[Sequence[float]] = (),
    bold: int | None = None,
) -> str:
    """Return a table whose first column names the rows.

    Parameters
    ----------
    rows
        Plain text of the cells.
    header
        Names of the columns.
    numbers
        Whether all columns but the first are numbers.
    shades
        For each row the shade of its cells after the first, 0 to 1.
    bold
        Index of a row to emphasise.
    """
    align = "right" if numbers else "left"
    lines = [_row("th", list(header), align, look="font-weight:600;")] if header else []
    for number, row in enumerate(rows):
        shade = shades[number] if shades else ()
        lines.append(_row("td", row, align, shade, look="font-weight:600;" if number == bold else ""))
    return f'<table style="{TABLE}">{"".join(lines)}</table>'


def box(title: str, *parts: str, remark: str = "", preformatted: str = "") -> str:
    """Return a title above tables, and below them a remark and a text with its own lines, all plain text."""
    below = f'<div style="opacity:0.75;font-size:90%">{escape(remark)}</div>' if remark else ""
    if preformatted:
        below += f'<pre style="font-size:90%">{escape(preformatted)}</pre>'
    return f'<div><div style="font-weight:600">{escape(title)}</div>{"".join(parts)}{below}</div>'


def caption(words: str) -> str:
    """Return a line of plain text between tables."""
    return f'<div style="margin-top:0.6em">{escape(words)}</div>'


def _row(tag: str, cells: Sequence[str], align: str, shade: Sequence[float] = (), look: str = "") -> str:
    styles = [CELL.format(align="left", wrap="nowrap", look=look)]
    for column in range(1, len(cells)):
        painted = SHADE.format(alpha=DARKEST * shade[column - 1]) if shade else ""
        wrap = "nowrap" if align == "right" else "normal"
        styles.append(CELL.format(align=align, wrap=wrap, look=look + painted))
    written = (
        f'<{tag} style="{style}">{escape(cell)}</{tag}>' for style, cell in zip(styles, cells, strict=True)
    )
    return f'<tr style="background:none">{"".join(written)}</tr>'
