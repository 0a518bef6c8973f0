"""The number of levels, chosen by objects that the tables have not seen."""

from dataclasses import replace

import numpy as np
import pytest

import beltsort
from beltsort.errors import DatabaseError
from beltsort.geometry import Points
from beltsort.perception import Finding, LabelRule, Match, fit_label_rule, leave_one_out, rule_of
from beltsort.tables import MatchedScan, Seen, choose_rule, estimate, fit_levels
from tests.perception.databases import database

CLASSES = ("nut", "bolt", "pin")
ONE, TWO = LabelRule(CLASSES), LabelRule(CLASSES, (0.5,))


def match(label: int, margin: float) -> Match:
    distances = np.full(3, 1.0 + margin)
    distances[label] = 1.0 - margin
    return Match(label, -distances, distances)


def scans(objects: int, looks: int = 1, *, telling: bool = True, seed: int = 0) -> list[MatchedScan]:
    """Return looks at objects, one from each of several viewpoints; large margins tell which are right."""
    rng = np.random.default_rng(seed)
    found = []
    for number in range(objects):
        true = number % 3
        for viewpoint in range(looks):
            right = rng.random() < 0.6
            label = true if right else int((true + rng.integers(1, 3)) % 3)
            sure = right == (rng.random() < 0.9) if telling else rng.random() < 0.5
            seen = match(label, 0.9 if sure else 0.1)
            found.append(MatchedScan(viewpoint, (true,), (f"object {number}",), (Seen(seen),)))
    return found


def test_levels_that_tell_are_chosen_and_those_that_do_not_are_not() -> None:
    assert choose_rule([ONE, TWO], scans(200), viewpoints=1).rule == TWO
    assert choose_rule([ONE, TWO], scans(200, telling=False), viewpoints=1).rule == ONE
    several = choose_rule([ONE, TWO], scans(200, looks=3), viewpoints=3)
    assert several.rule == TWO
    assert several.log_losses[1] < several.log_losses[0]


def test_losses_are_those_of_bayes_rule() -> None:
    """With one object of each class in each part, tables can be written down."""
    sure = [MatchedScan(0, (n % 3,), (None,), (Seen(match(n % 3, 0.9)),)) for n in range(3000)]
    (loss,) = choose_rule([ONE], sure, viewpoints=1, smoothing=1.0).log_losses
    right, wrong = 801 / 803, 1 / 803  # about 800 of each class in four parts
    assert loss == pytest.approx(-np.log(right / (right + 2 * wrong)), rel=0.05)


def test_names_of_classes_do_not_matter() -> None:
    order = [2, 0, 1]  # class c becomes number order[c]

    def moved(scan: MatchedScan) -> MatchedScan:
        seen, true = scan.seen[0].match, scan.true[0]
        assert seen is not None
        again = match(order[seen.label or 0], seen.margin or 0.0)
        return replace(scan, true=(order[true or 0],), seen=(Seen(again),))

    one, other = (
        choose_rule([ONE, TWO], each, viewpoints=1) for each in (scans(120), [*map(moved, scans(120))])
    )
    assert one.log_losses == pytest.approx(other.log_losses)


def test_the_same_division_for_every_rule() -> None:
    assert len(set(choose_rule([ONE] * 3, scans(40), viewpoints=1).log_losses)) == 1
    assert choose_rule([ONE, ONE], scans(40), viewpoints=1).rule is ONE


def test_a_repeated_look_counts_once() -> None:
    once = scans(60)
    assert choose_rule([TWO], once + once, viewpoints=1) == choose_rule([TWO], once, viewpoints=1)


def test_nothing_seen_says_something_where_it_has_a_label() -> None:
    """The bolt is never seen, the others are."""
    found = [
        replace(scan, seen=(Seen(None, Finding.HIDDEN),)) if scan.true == (1,) else scan for scan in scans(90)
    ]
    rules = [ONE, LabelRule(CLASSES, nothing_seen=True)]
    choice = choose_rule(rules, found, viewpoints=1)
    assert choice.rule.nothing_seen
    assert choice.log_losses[1] < choice.log_losses[0] - 0.1


class Own:
    classes = CLASSES

    def classify(self, points: Points, camera: Points) -> Match:
        pytest.fail("scans that are matched are not classified again")


def test_levels_are_fitted_with_a_classifier_of_ones_own() -> None:
    found = scans(200)
    choice = fit_levels(Own(), found, viewpoints=1)
    assert choice.rule.levels == 2
    assert 0.1 < choice.rule.edges[0] < 0.9
    assert len(choice.log_losses) == 4
    for levels in (1, 2):
        assert fit_levels(Own(), found, viewpoints=1, levels=levels).rule.levels == levels


def test_levels_of_probabilities() -> None:
    def probable(scan: MatchedScan) -> MatchedScan:
        seen = scan.seen[0].match
        assert seen is not None
        weights = np.where(np.arange(3) == seen.label, 5.0 + 4.0 * (seen.margin or 0.0), 1.0)
        weights /= weights.sum()
        return replace(scan, seen=(Seen(Match(seen.label, weights, probabilities=weights)),))

    choice = fit_levels(Own(), [*map(probable, scans(200))], viewpoints=1)
    assert (choice.rule.score, choice.rule.levels) == ("probability", 2)


def test_edges_of_a_database_come_from_its_own_entries() -> None:
    trained = database(n=60)
    matched = [
        MatchedScan(0, (true,), (None,), (Seen(seen),))
        for seen, true in zip(leave_one_out(trained), trained.labels.tolist(), strict=True)
    ]
    expected = fit_label_rule(trained.classes, leave_one_out(trained), trained.labels.tolist(), 3)
    assert fit_levels(trained, matched[:30], viewpoints=1, levels=3).rule == expected


def test_a_model_is_estimated_with_its_rule() -> None:
    found = scans(200)
    rule = fit_levels(Own(), found, viewpoints=1).rule
    result = estimate([scan.labelled(rule) for scan in found], CLASSES, ["above"], rule=rule)
    assert rule_of(result.model) == rule
    assert result.model.p_obs.shape == (1, 1, 3, 6)
    assert result.to_dict()["labels"] == list(rule.labels)
    loaded = beltsort.SortingModel.from_json(result.model.to_json())
    assert rule_of(loaded) == rule


def test_scans_are_labelled_by_the_rule() -> None:
    scan = MatchedScan(2, (0, None), ("a", None), (Seen(match(1, 0.9)), Seen(None, Finding.EMPTY)))
    labelled = scan.labelled(LabelRule(CLASSES, (0.5,), nothing_seen=True))
    assert (labelled.viewpoint, labelled.true, labelled.objects) == (2, (0, None), ("a", None))
    assert labelled.observed == (3, 6)
    assert scan.labelled(ONE).observed == (1, None)


def test_what_cannot_be_chosen_from_is_refused() -> None:
    with pytest.raises(beltsort.ArgumentError, match=r"\brules\b.*\[\].*\bone\b"):
        choose_rule([], scans(9), viewpoints=1)
    with pytest.raises(beltsort.ArgumentError, match=r"'nut', 'bolt', 'pin'.*\bsame\b"):
        choose_rule([ONE, LabelRule(("nut", "bolt"))], scans(9), viewpoints=1)
    with pytest.raises(beltsort.ArgumentError, match=r"\b0 objects\b.*\b2\b"):
        choose_rule([ONE], [], viewpoints=1)
    bare = [replace(scan, seen=(Seen(Match(0, np.ones(3))),)) for scan in scans(9)]
    with pytest.raises(DatabaseError, match=r"\bdistances\b"):
        choose_rule([TWO], bare, viewpoints=1)
