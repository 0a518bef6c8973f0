"""Signatures as the source has them: type aliases by their names, and protocols without a constructor."""

import re
from typing import Any

from numpy.typing import ArrayLike
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

ARRAY = re.compile(r"~?numpy\.ndarray\[tuple\[~?typing\.Any, \.\.\.\], ~?numpy\.dtype\[([^\[\]]*)\]\]")
ARRAY_LIKE = stringify_annotation(ArrayLike, "smart")


def shortened(signature: str) -> str:
    """Return a signature, or its return type, with NumPy's aliases instead of what they stand for."""
    return ARRAY.sub(r"~numpy.typing.NDArray[\1]", signature.replace(ARRAY_LIKE, "~numpy.typing.ArrayLike"))


def process(
    _app: Sphinx,
    _what: str,
    _name: str,
    thing: Any,
    _options: object,
    signature: str | None,
    returned: str | None,
) -> tuple[str | None, str | None]:
    """Return the signature and the return type to show."""
    if getattr(thing, "_is_protocol", False):
        return "", None
    return signature and shortened(signature), returned and shortened(returned)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the processing."""
    app.connect("autodoc-process-signature", process)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
