"""Links between pages of the repository's root, and a language of their code blocks, in this site."""

from docutils import nodes
from pygments.lexers.special import TextLexer
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode

PAGES = {
    "ARCHITECTURE.md": "architecture",
    "CHANGELOG.md": "changelog",
    "CONTRIBUTING.md": "contributing",
    "README.md": "index",
}


def resolve(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.reference | None:
    """Return the link to a page that includes a file of the root."""
    page = PAGES.get(node["reftarget"].removeprefix("../"))
    if page is None:
        return None
    return make_refnode(app.builder, node.get("refdoc", env.docname), page, None, content)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register both."""
    app.connect("missing-reference", resolve)
    app.add_lexer("rooms", TextLexer)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
