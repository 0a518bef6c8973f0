"""The rule that turns what a classifier returns into a label."""

import json
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import beltsort
from beltsort.errors import DatabaseError
from beltsort.geometry import BeltLayout
from beltsort.perception import (
    Finding,
    LabelRule,
    Match,
    NearestNeighbour,
    Perception,
    leave_one_out,
    perception_for,
    rule_of,
)
from beltsort.perception.label_rule import LEVEL_NAMES, score_of
from tests.perception.belt_scene import Scene
from tests.perception.databases import CLASSES, database
from tests.perception.test_pipeline import trained

EDGES = st.lists(st.floats(-1.0, 1.0), max_size=3, unique=True).map(lambda edges: tuple(sorted(edges)))
DISTANCES = st.lists(st.floats(0.0, 1e300) | st.just(np.inf), min_size=3, max_size=3).map(np.array)
PROBABILITIES = st.lists(st.floats(1e-9, 1.0), min_size=3, max_size=3).map(
    lambda weights: np.array(weights) / np.sum(weights)
)
RULES = st.builds(
    LabelRule,
    st.just(tuple(CLASSES)),
    EDGES,
    st.sampled_from(["margin", "probability"]),
    st.booleans(),
    st.booleans(),
)


@st.composite
def matches(draw: st.DrawFn) -> Match:
    distances, probabilities = draw(DISTANCES), draw(PROBABILITIES)
    label = draw(st.none() | st.integers(0, 2))
    return Match(label, probabilities, distances, probabilities)


@given(RULES, matches(), st.sampled_from(list(Finding)))
def test_everything_seen_gets_exactly_one_label_if_the_rule_has_one_for_all(
    rule: LabelRule, match: Match, finding: Finding
) -> None:
    complete = replace(rule, not_recognised=True, nothing_seen=True)
    for seen in (match, None):
        label = complete.label(seen, finding)
        assert label is not None
        assert 0 <= label < len(complete.labels) == 3 * rule.levels + 2
        fewer = rule.label(seen, finding)
        assert fewer is None or rule.labels[fewer] == complete.labels[label], "fewer labels, no other ones"


@given(RULES, matches())
def test_a_label_names_the_class_of_the_match(rule: LabelRule, match: Match) -> None:
    label = rule.label(match)
    if match.label is None:
        assert label is None or rule.label_classes[label] is None
    else:
        assert label is not None
        assert rule.label_classes[label] == match.label
        assert rule.labels[label].startswith(CLASSES[match.label])


@given(RULES, matches(), matches())
def test_more_confidence_is_no_lower_level(rule: LabelRule, one: Match, other: Match) -> None:
    one, other = replace(one, label=1), replace(other, label=1)
    low, high = sorted((one, other), key=lambda match: score_of(match, rule.score))
    assert (rule.label(low) or 0) <= (rule.label(high) or 0)


@given(RULES, matches(), st.permutations(range(3)))
def test_relabelling_classes_relabels_labels(rule: LabelRule, match: Match, order: list[int]) -> None:
    """Class c becomes number `order.index(c)`."""
    again = replace(rule, classes=tuple(CLASSES[c] for c in order))
    assert match.distances is not None
    assert match.probabilities is not None
    moved = Match(
        None if match.label is None else order.index(match.label),
        match.scores[order],
        match.distances[order],
        match.probabilities[order],
    )
    first, second = rule.label(match), again.label(moved)
    named = None if first is None else rule.labels[first]
    assert named == (None if second is None else again.labels[second])


@given(matches(), st.sampled_from(list(Finding)))
def test_one_level_is_the_class_as_before(match: Match, finding: Finding) -> None:
    rule = LabelRule(tuple(CLASSES))
    assert rule.labels == tuple(CLASSES)
    assert rule.label(match, finding) == match.label
    assert rule.label(None, finding) is None
    assert rule.label(replace(match, distances=None, probabilities=None)) == match.label


@given(RULES)
def test_json_keeps_a_rule_exactly(rule: LabelRule) -> None:
    assert LabelRule.from_dict(rule.to_dict()) == rule
    assert LabelRule.from_dict(json.loads(json.dumps(rule.to_dict()))) == rule


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
    max_leaves=8,
)


@given(st.sampled_from(["classes", "edges", "score", "not_recognised", "nothing_seen", "level"]), JSON)
def test_any_value_of_a_key_is_a_rule_or_an_error(key: str, value: object) -> None:
    with suppress(beltsort.ArgumentError):
        rule = LabelRule.from_dict({**LabelRule(("a", "b"), (0.5,)).to_dict(), key: value})
        assert LabelRule.from_dict(rule.to_dict()) == rule


@given(JSON)
def test_any_json_is_a_rule_or_an_error(value: object) -> None:
    with suppress(beltsort.ArgumentError):
        LabelRule.from_dict(value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[]", r"\[\].*\bclasses\b"),
        ('{"edges": []}', r"\bclasses\b.*\bmissing\b"),
        ('{"classes": ["a"], "edgse": []}', r"\bedgse\b.*'edges'"),
        ('{"classes": ["a"], "edges": ["0.5"]}', r"edges\[0\].*'0\.5'"),
        ('{"classes": ["a"], "edges": [1e999]}', r"\bedges\b.*\binf\b"),
    ],
)
def test_json_that_is_no_rule_is_refused(text: str, said: str) -> None:
    with pytest.raises(beltsort.ArgumentError, match=said):
        LabelRule.from_dict(json.loads(text))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"edges": (0.5, 0.5)}, r"\bedges\b.*\[0\.5, 0\.5\]"),
        ({"edges": (0.5, 0.2)}, r"\bedges\b.*\[0\.5, 0\.2\]"),
        ({"edges": (np.nan,)}, r"\bedges\b.*\bnan\b"),
        ({"edges": (0.1, 0.2, 0.3, 0.4)}, r"\b4 edges\b.*\b3\b"),
        ({"score": "entropy"}, r"\bscore\b.*'entropy'.*'margin', 'probability'"),
        ({"classes": ()}, r"\blabels\b.*\[\]"),
        ({"classes": ("a", "a")}, r"\blabels\b.*\['a', 'a'\]"),
        ({"classes": ("not recognised",), "not_recognised": True}, r"\blabels\b.*'not recognised'"),
    ],
)
def test_settings_without_sense_are_refused(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(beltsort.ArgumentError, match=said):
        LabelRule(**{"classes": ("a", "b"), **settings})


def test_levels_have_names() -> None:
    for edges, names in enumerate(LEVEL_NAMES):
        rule = LabelRule(("bulb",), tuple(0.1 * (n + 1) for n in range(edges)))
        expected = [f"bulb, {name}" if name else "bulb" for name in names]
        assert list(rule.labels) == expected
        assert rule.levels == len(names)


@pytest.mark.parametrize(
    ("label", "distances", "margin"),
    [
        (0, [1.0, 3.0, 4.0], 0.5),
        (None, [1.0, 3.0, 4.0], 0.5),
        (1, [1.0, 3.0, 4.0], -0.5),
        (0, [0.0, 2.0, 3.0], 1.0),
        (0, [0.0, 0.0, 3.0], 0.0),
        (0, [5.0, np.inf, np.inf], 1.0),
        (0, [np.inf, np.inf, np.inf], 0.0),
        (0, [np.inf, 5.0, 6.0], -1.0),
        (0, [2.0], 1.0),
    ],
)
def test_the_margin_by_hand(label: int | None, distances: list[float], margin: float) -> None:
    match = Match(label, -np.nan_to_num(np.array(distances), posinf=1e9), np.array(distances))
    assert match.margin == margin


def test_a_score_equal_to_an_edge_is_of_the_level_above() -> None:
    rule = LabelRule(tuple(CLASSES), (0.5,))
    assert rule.labels[rule.label(Match(0, np.zeros(3), np.array([1.0, 3.0, 4.0]))) or 0] == "a, sure"


@pytest.mark.parametrize(("score", "missing"), [("margin", "distances"), ("probability", "probabilities")])
def test_a_classifier_that_does_not_return_the_score_is_refused(score: Any, missing: str) -> None:
    with pytest.raises(DatabaseError, match=rf"\b{missing}\b.*'{score}'"):
        LabelRule(tuple(CLASSES), (0.5,), score).label(Match(1, np.zeros(3)))


def test_a_classifier_of_other_classes_is_refused() -> None:
    rule = LabelRule(("a", "b"))
    with pytest.raises(DatabaseError, match=r"\b3\b.*\['a', 'b'\]"):
        rule.label(Match(1, np.zeros(3)))
    with pytest.raises(DatabaseError, match=r"\brule\b.*\['a', 'b'\].*\['a', 'b', 'c'\]"):
        Perception(BeltLayout(), database(), rule=rule)


def test_a_model_keeps_its_rule() -> None:
    rule = LabelRule(("a", "b"), (0.123456789012345, 0.3), nothing_seen=True)
    p_obs = np.full((1, 1, 2, 7), 1.0 / 7.0)
    model = beltsort.SortingModel(
        rule.classes, ["above"], p_obs, labels=rule.labels, label_rule=rule.to_dict()
    )
    assert rule_of(model) == rule_of(beltsort.SortingModel.from_json(model.to_json())) == rule
    plain = beltsort.SortingModel(["a", "b"], ["above"], [[[[0.5, 0.5], [0.1, 0.9]]]])
    assert rule_of(plain) == LabelRule(("a", "b"))


def test_a_rule_need_not_know_empty_cups() -> None:
    rule, p_obs = LabelRule(tuple(CLASSES), (0.3,)), np.full((1, 1, 4, 7), 1.0 / 7.0)
    model = beltsort.SortingModel(
        [*CLASSES, "none"],
        ["above"],
        p_obs,
        labels=[*rule.labels, "none"],
        label_rule=rule.to_dict(),
        empty="none",
    )
    assert rule_of(model) == rule
    assert perception_for(model, BeltLayout(), database()).labels == rule.labels


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        (None, r"\blabels\b.*\['a', 'b', 'c'\].*\['a', 'b'\].*\bclasses\b"),
        ({"classes": ["a", "b"]}, r"\['a', 'b', 'c'\].*\['a', 'b'\].*\blabel_rule\b"),
        ({"classes": ["a", "b", "c"]}, r"\['a', 'b', 'c'\].*\blabel_rule\b"),
        ({"edges": [0.5]}, r"\bclasses\b.*\bmissing\b"),
    ],
)
def test_labels_that_the_rule_does_not_make_are_refused(kept: dict[str, Any] | None, said: str) -> None:
    p_obs = np.full((1, 1, 2, 3), 1.0 / 3.0)
    labels = ["a", "b", "c"]
    model = beltsort.SortingModel(["a", "b"], ["above"], p_obs, labels=labels, label_rule=kept)
    with pytest.raises(beltsort.ArgumentError, match=said):
        rule_of(model)


def test_what_is_too_far_is_not_recognised() -> None:
    near = database()
    query = database(seed=1).descriptors[0]
    far = replace(near, reject=(near.match(query).distance or 0.0) / 2.0)
    rule = LabelRule(tuple(CLASSES), (0.01,), not_recognised=True)
    assert rule.labels[rule.label(near.match(query)) or 0].startswith(CLASSES[near.match(query).label or 0])
    assert rule.labels[rule.label(far.match(query)) or 0] == "not recognised"
    assert replace(rule, not_recognised=False).label(far.match(query)) is None


def test_leaving_one_out_has_margins() -> None:
    margins = [match.margin for match in leave_one_out(database(n=30))]
    assert all(margin is not None and 0.0 <= margin <= 1.0 for margin in margins)
    assert len(set(margins)) > 20


def test_perception_labels_by_the_rule() -> None:
    scene = Scene(BeltLayout(), np.random.default_rng(3))
    scan = scene.scan(scene.belt(), scene.ellipsoid(0, (0.015, 0.015, 0.05)))
    known: NearestNeighbour = trained()
    plain, _ = Perception(BeltLayout(), known)(scan)
    assert plain.match is not None
    assert plain.match.margin is not None
    edge = plain.match.margin
    for above, level in ((edge, "sure"), (edge + 1e-9, "unsure")):
        rule = LabelRule(known.classes, (above,), nothing_seen=True)
        seen, empty = Perception(BeltLayout(), known, rule=rule)(scan)
        assert rule.labels[seen.label or 0] == f"{known.classes[plain.label or 0]}, {level}"
        assert empty.label is not None
        assert (rule.labels[empty.label], empty.empty) == ("nothing seen", True)
