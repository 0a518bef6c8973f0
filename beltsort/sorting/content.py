"""The base class of the contents of journal entries."""

from collections.abc import Mapping
from typing import ClassVar


class Content:
    """The content of an entry.

    Attributes
    ----------
    kind
        Name of this kind of entry in the journal; two classes may share it.
    """

    kind: ClassVar[str]
    __pydantic_config__: ClassVar[Mapping[str, str]] = {"extra": "forbid"}
