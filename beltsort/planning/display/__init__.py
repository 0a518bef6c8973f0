"""Text and HTML of models, beliefs, plans, policies and evaluations, for the REPL and for notebooks.

The extension calls `text` for `repr` and `html` for `_repr_html_`.
"""

from beltsort.planning.display.html import html
from beltsort.planning.display.text import text

__all__ = ["html", "text"]
