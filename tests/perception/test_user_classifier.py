"""Any classifier labels scans: one of a user's own goes through the pipeline, and one that rejects."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort.geometry import BeltLayout, Points
from beltsort.perception import Classifier, Match, Perception, PerceptionConfig
from tests.perception.belt_scene import Scene
from tests.perception.test_pipeline import trained

LAYOUT = BeltLayout()


class ByHeight:
    """Low or high above the cup's rim; what is very high is no object of mine."""

    classes = ("low", "high")

    def classify(self, points: Points, camera: Points) -> Match:
        assert camera.shape == (3,)
        height = points[:, 2].max() - LAYOUT.rim_height
        label = None if height > 0.1 else int(height > 0.05)
        return Match(label, np.array([0.1 - height, height]))


def perceived(classifier: Classifier, *semi_axes: tuple[float, float, float]) -> list[Any]:
    scene = Scene(LAYOUT, np.random.default_rng(3))
    objects = [scene.ellipsoid(j, axes) for j, axes in enumerate(semi_axes)]
    return Perception(LAYOUT, classifier)(scene.scan(scene.belt(), *objects))


def test_a_users_classifier_labels_scans() -> None:
    low, high = perceived(ByHeight(), (0.03, 0.03, 0.02), (0.02, 0.02, 0.05))
    assert (low.label, high.label) == (0, 1)
    for seen in (low, high):
        assert (seen.distance, seen.runner_up) == (None, None)


def test_what_it_does_not_know_is_no_empty_place() -> None:
    unknown, empty = perceived(ByHeight(), (0.03, 0.03, 0.09))
    assert (unknown.label, unknown.empty) == (None, False)
    assert (empty.label, empty.empty) == (None, True)


def test_a_database_that_rejects_leaves_the_object_without_a_label() -> None:
    known = perceived(trained(), (0.015, 0.015, 0.05))[0]
    unknown = perceived(replace(trained(), reject=1e-9), (0.015, 0.015, 0.05))[0]
    assert (known.label, unknown.label, unknown.empty) == (1, None, False)
    assert (unknown.distance, unknown.runner_up) == (known.distance, known.runner_up)


def test_it_takes_the_configuration_that_is_given() -> None:
    config = PerceptionConfig(voxel=0.006)
    assert Perception(LAYOUT, ByHeight(), config).config == config
    assert Perception(LAYOUT, ByHeight()).config == PerceptionConfig()


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda: Match(2, np.ones(2)), r"\blabel\b.*\b2\b.*\b0\b.*\b1\b.*\bNone\b"),
        (lambda: Match(-1, np.ones(2)), r"\blabel\b.*-1\b.*\b0\b.*\b1\b.*\bNone\b"),
        (lambda: Match(0, np.array([1.0, np.nan])), r"\bscores\b.*\bnan\b"),
        (lambda: Match(0, np.ones((2, 2))), r"(?s)\bscores\b.*\[1\. 1\.\]\].*\(L,\)"),
        (lambda: Match(None, np.ones(0)), r"\bscores\b.*\[\].*\(L,\)"),
        (lambda: Match(0, np.ones(2), np.ones(3)), r"\bdistances\b.*\(3,\).*\(2,\)"),
        (lambda: Match(0, np.ones(2), np.array([1.0, np.nan])), r"\bdistances\b.*\bnan\b"),
        (lambda: Match(0, np.ones(2), np.array([1.0, -1.0])), r"\bdistances\b.*-1\b"),
        (lambda: Match(0, np.ones(2), None, np.ones(3) / 3), r"\bprobabilities\b.*\(3,\).*\(2,\)"),
        (lambda: Match(0, np.ones(2), None, np.array([0.5, 0.4])), r"\bprobabilities\b.*\b0\.9\b.*\b1\b"),
        (lambda: Match(0, np.ones(2), None, np.array([1.5, -0.5])), r"\bprobabilities\b.*-0\.5\b"),
        (lambda: Match(0, np.ones(2), None, np.array([1.0, np.nan])), r"\bprobabilities\b.*\bnan\b"),
    ],
)
def test_answers_without_sense_are_refused(answer: Callable[[], Match], said: str) -> None:
    with pytest.raises(beltsort.ArgumentError, match=said):
        answer()


def test_ranking_is_by_score_then_distance_then_number() -> None:
    scores = np.array([0.0, 0.5, 0.5, 0.0, 0.0])
    assert Match(None, scores, np.array([9.0, 4.0, 3.0, 2.0, 2.0])).ranking == (2, 1, 3, 4, 0)
    assert Match(None, scores).ranking == (1, 2, 0, 3, 4)
