"""The documentation's site: `make docs` builds it into docs/_build/html."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

import beltsort  # noqa: E402 - found by the line above

project = "beltsort"
version = release = beltsort.__version__
copyright = "the authors of beltsort, Apache-2.0"

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_copybutton",
    "ext.commands",
    "ext.mathml",
    "ext.repository",
    "ext.signatures",
    "ext.code_links",
]
exclude_patterns = ["_build", "_templates", "results"]
templates_path = ["_templates"]
smartquotes = False
nitpicky = True
# Classes of other packages: their sites' inventories would have to be fetched.
nitpick_ignore_regex = [
    (
        r"py:.*",
        r"(np|npt|numpy|pd|pandas|matplotlib|collections|pathlib|os|argparse|datetime|types|typing|enum)\..*",
    ),
    # Type variables, and imports for type checkers only.
    (r"py:.*", r"(.*\.)?(Options|Result|Stored|CellDescription)"),
    (r"py:.*", r"tuple\[.*"),
    (r"py:.*", r"(Axes|NDArray|ArrayLike|Path|PathLike|Any|optional|default.*|shape.*|Callable|Sequence)"),
]

# Markdown.
myst_enable_extensions = ["deflist", "fieldlist"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # the tests execute the notebooks and compare their outputs

# Docstrings.
toc_object_entries_show_parents = "hide"
autosummary_generate = True
autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
numpydoc_show_class_members = False  # the members follow in full
numpydoc_class_members_toctree = False
default_role = "code"

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = "beltsort"
html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_sidebars: dict[str, list[str]] = {"gallery": []}  # it has no pages below it
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "show_prev_next": True,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "pygments_light_style": "tango",
}
