"""Links from code in a text to what it names: objects of the reference, and commands.

Pages and docstrings write `beltsort.Despot`, `Belief` or `beltsort plan paper` as plain code, which reads
well on GitHub and with `help` too.
"""

import re
from typing import cast

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.domains.python import PythonDomain
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.nodes import make_refnode

OBJECT = re.compile(r"([A-Za-z_][\w.]*)(\(.*\))?", re.DOTALL)
COMMAND = re.compile(r"beltsort ([a-z][a-z-]*)\b.*", re.DOTALL)
NO_LINKS = (nodes.reference, nodes.title, pending_xref)


class CodeLinks(SphinxPostTransform):
    """Make literals that name an object of the reference, or a command, links to it."""

    default_priority = 400

    def run(self, **_: object) -> None:
        """Go through the literals of a page."""
        for literal in list(self.document.findall(nodes.literal)):
            if literal.get("classes") and "code" not in literal["classes"]:
                continue
            if any(isinstance(above, NO_LINKS) for above in _ancestors(literal)):
                continue
            reference = self._reference(literal)
            if reference is not None:
                literal.replace_self(reference)

    def _reference(self, literal: nodes.literal) -> nodes.reference | None:
        text = literal.astext()
        page, anchor = self._object(text) or self._command(text) or ("", "")
        if not page or page == self.env.docname:
            return None
        return make_refnode(self.app.builder, self.env.docname, page, anchor, literal.deepcopy(), text)

    def _object(self, text: str) -> tuple[str, str] | None:
        match = OBJECT.fullmatch(text)
        if match is None:
            return None
        objects = cast(PythonDomain, self.env.get_domain("py")).objects
        name = match[1]
        for candidate in (name, f"beltsort.{name}", f"beltsort.perception.{name}"):
            if candidate in objects:
                return objects[candidate].docname, objects[candidate].node_id
        return None

    def _command(self, text: str) -> tuple[str, str] | None:
        match = COMMAND.fullmatch(text)
        page = f"commands/{match[1]}" if match else ""
        return (page, "") if page in self.env.found_docs else None


def _ancestors(node: nodes.Node) -> list[nodes.Node]:
    above: list[nodes.Node] = []
    while node.parent is not None:
        node = node.parent
        above.append(node)
    return above


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the transform."""
    app.add_post_transform(CodeLinks)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
