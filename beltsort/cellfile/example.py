"""Cell files that come with the package, to start one's own from."""

from importlib.resources import files
from typing import NamedTuple

from beltsort._core import ArgumentError
from beltsort.util.naming import nearest_of


class Example(NamedTuple):
    """A cell file.

    Attributes
    ----------
    name
        What it is asked for by.
    text
        The file (TOML); its first line is a comment that says what cell it describes.
    """

    name: str
    text: str

    @property
    def title(self) -> str:
        """What cell it describes."""
        return self.text.partition("\n")[0].removeprefix("#").strip()


def examples() -> list[Example]:
    """Return the cell files, by name.

    Examples
    --------
    >>> [example.name for example in examples()]
    ['moving', 'opcua', 'simulated']
    """
    found = (files(__package__) / "examples").iterdir()
    texts = {file.name.removesuffix(".toml"): file for file in found if file.name.endswith(".toml")}
    return [Example(name, texts[name].read_text("utf-8")) for name in sorted(texts)]


def example(name: str) -> Example:
    """Return the cell file of a name.

    Raises
    ------
    ArgumentError
        If there is none.

    Examples
    --------
    >>> example("simulated").title
    'A simulated cell that sorts ten bulbs; docs/cell.md explains every key.'
    """
    known = {each.name: each for each in examples()}
    if name not in known:
        raise ArgumentError(f"there is no example {name!r}; {nearest_of(name, list(known))}")
    return known[name]
