"""Links between pages of the repository's root, and a language of their code blocks, in this site."""

from pygments.lexers.special import TextLexer
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

PAGES = {
    "ARCHITECTURE.md": "architecture",
    "CHANGELOG.md": "changelog",
    "CONTRIBUTING.md": "contributing",
    "README.md": "index",
}


class RootLinks(SphinxTransform):
    """Point links to files of the root at the pages that include them."""

    default_priority = 800

    def apply(self, **_: object) -> None:
        """Go through the links of a page."""
        for link in self.document.findall(pending_xref):
            page = PAGES.get(link["reftarget"].removeprefix("../"))
            if page is not None:
                link["refdomain"], link["reftarget"], link["reftargetid"] = "doc", page, None


def setup(app: Sphinx) -> dict[str, bool]:
    """Register both."""
    app.add_transform(RootLinks)
    app.add_lexer("rooms", TextLexer)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
