"""Walking the tree of a plan."""

from collections.abc import Iterator

from beltsort.planning.plan_tree import TreeNode


def nodes(node: TreeNode) -> Iterator[TreeNode]:
    """All beliefs of a tree, from the root down."""
    yield node
    for action in node["actions"]:
        for branch in action["branches"]:
            yield from nodes(branch["node"])
