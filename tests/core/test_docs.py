"""Everything public says what it is, and its examples are true."""

import doctest
import inspect
from collections.abc import Iterator
from typing import Any

import pytest

import beltsort

INHERITED = dir(Exception)


def public_things() -> Iterator[tuple[str, Any]]:
    for name in beltsort.__all__:
        thing = getattr(beltsort, name)
        yield name, thing
        if inspect.isclass(thing):
            for member, value in sorted(vars(thing).items()):  # the same in every process
                if not member.startswith("_") and member not in INHERITED:
                    yield f"{name}.{member}", value


THINGS = dict(public_things())
del THINGS["__version__"]


@pytest.mark.parametrize("name", THINGS)
def test_documented(name: str) -> None:
    doc = inspect.getdoc(THINGS[name])
    assert doc
    assert max(map(len, doc.splitlines())) <= 110


@pytest.mark.parametrize("name", [name for name, thing in THINGS.items() if ">>>" in (thing.__doc__ or "")])
def test_examples(name: str) -> None:
    example = doctest.DocTestParser().get_doctest(inspect.getdoc(THINGS[name]) or "", {}, name, None, None)
    assert doctest.DocTestRunner().run(example).failed == 0


def test_there_are_examples() -> None:
    documented = {name for name, thing in THINGS.items() if ">>>" in (thing.__doc__ or "")}
    assert {
        "SortingModel",
        "Belief",
        "Despot",
        "Threshold",
        "InformationGain",
        "OneObject",
        "evaluate",
        "Policy",
    } <= documented
