"""Keywords that a constructor or function of the extension does not have."""

import inspect
import re
from collections.abc import Callable
from typing import Any

import pytest

import beltsort
from beltsort.models import paper

MODEL = paper()
BELIEF = beltsort.Belief(MODEL)
SETS = (MODEL.classes, MODEL.viewpoints, MODEL.p_obs)

CALLS: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
    "SortingModel": (beltsort.SortingModel, SETS),
    "Belief": (beltsort.Belief, (MODEL,)),
    "Despot": (beltsort.Despot, (MODEL,)),
    "Despot.plan": (beltsort.Despot(MODEL, trials=1).plan, (BELIEF,)),
    "LookAhead": (beltsort.LookAhead, (MODEL,)),
    "Threshold": (beltsort.Threshold, (MODEL, 0.9)),
    "InformationGain": (beltsort.InformationGain, (MODEL, 0.9)),
    "evaluate": (beltsort.evaluate, (MODEL, beltsort.Threshold(MODEL, 0.9))),
    "solve": (beltsort.solve, (MODEL,)),
}


@pytest.mark.parametrize(
    ("name", "given", "meant"),
    [
        ("SortingModel", "r_mim", "r_min"),
        ("Belief", "remainder", "remaining"),
        ("Despot", "trial", "trials"),
        ("Despot.plan", "second", "seconds"),
        ("LookAhead", "scenario", "scenarios"),
        ("Threshold", "view", "viewpoint"),
        ("InformationGain", "position", "positions"),
        ("evaluate", "batchs", "batches"),
        ("solve", "stopped", "stop"),
    ],
)
def test_an_unknown_keyword_is_told_the_nearest(name: str, given: str, meant: str) -> None:
    call, arguments = CALLS[name]
    with pytest.raises(TypeError, match=rf"^{name} has no .*{given!r}; did you mean {meant!r}\? Known: .*"):
        call(*arguments, **{given: 4})


@pytest.mark.parametrize("policy", [beltsort.Threshold, beltsort.InformationGain])
def test_a_misspelt_threshold_is_told_before_the_missing_one(policy: Callable[..., Any]) -> None:
    with pytest.raises(TypeError, match="no parameter 'treshold'; did you mean 'threshold'"):
        policy(MODEL, treshold=0.9)
    with pytest.raises(TypeError, match=f'{policy.__name__} needs the argument "threshold"'):
        policy(MODEL)


def test_a_changed_model_suggests_them_too() -> None:
    with pytest.raises(TypeError, match="'discuont'; did you mean 'discount'"):
        MODEL.replace(discuont=0.9)


@pytest.mark.parametrize("name", CALLS)
def test_every_parameter_of_the_signature_is_one(name: str) -> None:
    call, arguments = CALLS[name]
    optional = list(inspect.signature(call).parameters.values())[len(arguments) :]
    assert optional
    for parameter in optional:
        assert parameter.kind is not inspect.Parameter.VAR_KEYWORD
        with pytest.raises((TypeError, ValueError)) as caught:
            call(*arguments, **{parameter.name: object(), "no_such_keyword": 1})
        if refused := re.search("no parameter '(.*?)'", str(caught.value)):
            assert refused[1] == "no_such_keyword"
