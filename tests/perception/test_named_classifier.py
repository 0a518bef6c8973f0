"""Classifiers by name, and those that return probabilities."""

import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.errors import DatabaseError
from beltsort.geometry import BeltLayout, Points
from beltsort.perception import (
    FromProbabilities,
    LabelRule,
    Match,
    NearestNeighbour,
    Perception,
    load_classifier,
    named_classifier,
)
from beltsort.perception.named_classifier import as_classifier
from tests.perception.belt_scene import Scene
from tests.perception.databases import CLASSES, database

CLOUD, CAMERA = np.zeros((5, 3)), np.ones(3)


class Returning:
    """A classifier that returns the same probabilities for everything."""

    classes: tuple[str, ...] = ("a", "b", "c")

    def __init__(self, given: Any = (0.2, 0.5, 0.3)) -> None:
        self.given = given

    def probabilities(self, points: Points, camera: Points) -> Any:
        return self.given


CODE = """
import numpy as np
from beltsort.perception import Match

class Network:
    classes = ["a", "b"]
    def probabilities(self, points, camera):
        return [0.25, 0.75]

class Both(Network):
    def classify(self, points, camera):
        return Match(0, np.ones(2))

class Needy(Network):
    def __init__(self, weights):
        pass

class Named(Network):
    def __init__(self, classes):
        self.classes = classes

def load():
    return Network()

def fail():
    raise RuntimeError("no such weights")

class inner:
    network = Network()

NETWORK, BOTH, NUMBER = Network(), Both(), 7
UNNAMED, TWICE, TEXT = Named([]), Named(["a", "a"]), Named("ab")
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder with a user's modules, which are forgotten afterwards."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "toy_networks.py").write_text(CODE)
    (tmp_path / "toy_needs.py").write_text("import a_package_that_is_missing\n")
    (tmp_path / "toy_broken.py").write_text("def (:\n")
    yield tmp_path
    for name in ("toy_networks", "toy_needs", "toy_broken"):
        sys.modules.pop(name, None)


@given(st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3).filter(lambda weights: sum(weights) > 1e-9))
def test_the_most_probable_class_is_the_label(weights: list[float]) -> None:
    probabilities = np.array(weights) / sum(weights)
    match = FromProbabilities(Returning(probabilities.tolist())).classify(CLOUD, CAMERA)
    assert match.label == match.ranking[0] == probabilities.argmax()
    assert match.probabilities is not None
    np.testing.assert_array_equal(match.probabilities, probabilities)
    assert match.margin is None


def test_a_softmax_in_single_precision_is_a_distribution() -> None:
    logits = np.random.default_rng(0).normal(0.0, 5.0, 1000).astype(np.float32)
    classifier = Returning(np.exp(logits) / np.exp(logits).sum())
    classifier.classes = tuple(f"class {n}" for n in range(1000))
    assert FromProbabilities(classifier).classify(CLOUD, CAMERA).label == logits.argmax()


@pytest.mark.parametrize(
    ("returned", "said"),
    [
        ([0.5, 0.5], r"\bshape \(2,\).*\(3,\)"),
        ([[0.2, 0.5, 0.3]], r"\bshape \(1, 3\).*\(3,\)"),
        (0.5, r"\bshape \(\).*\(3,\)"),
        (None, r"\bshape \(\)|\bnumbers\b"),
        ("abc", r"\bnumbers\b"),
        ([0.2, 0.5, 0.2], r"\bsum 0\.9\b.*\b1\b"),
        ([2.0, 5.0, 3.0], r"\bsum 10\b.*\b1\b"),
        ([1.2, -0.2, 0.0], r"-0\.2\b.*\bnegative\b"),
        ([np.nan, 0.5, 0.5], r"\bnan\b.*\bfinite\b"),
    ],
)
def test_what_is_no_distribution_is_refused(returned: Any, said: str) -> None:
    with pytest.raises(
        DatabaseError, match=rf"(?s)\bReturning\b.*\['a', 'b', 'c'\].*\bprobabilities\b.*({said})"
    ):
        FromProbabilities(Returning(returned)).classify(CLOUD, CAMERA)


def test_perception_labels_by_probabilities_with_confidence() -> None:
    layout = BeltLayout()
    scene = Scene(layout, np.random.default_rng(3))
    scan = scene.scan(scene.belt(), scene.ellipsoid(0, (0.03, 0.03, 0.02)))
    rule = LabelRule(Returning.classes, (0.6,), "probability")
    for returned, label in (((0.2, 0.5, 0.3), "b, unsure"), ((0.2, 0.7, 0.1), "b, sure")):
        seen, _ = Perception(layout, Returning(returned), rule=rule)(scan)
        assert rule.labels[seen.label or 0] == label
        assert seen.distance is None


@pytest.mark.parametrize("name", ["NETWORK", "Network", "load", "inner.network"])
def test_an_object_of_a_module_beside_the_file(folder: Path, name: str) -> None:
    classifier = load_classifier(f"toy_networks:{name}", folder)
    assert classifier.classes == ("a", "b")
    match = classifier.classify(CLOUD, CAMERA)
    assert (match.label, match.scores.tolist()) == (1, [0.25, 0.75])


def test_a_classifier_stays_as_it_is(folder: Path) -> None:
    assert load_classifier("toy_networks:BOTH", folder).classify(CLOUD, CAMERA).label == 0
    known = database()
    assert as_classifier(known) is known


def test_an_installed_module_comes_before_the_folder(folder: Path) -> None:
    (folder / "json.py").write_text("raise RuntimeError")
    with pytest.raises(DatabaseError, match="'json' has no attribute 'CLASSIFIER'"):
        load_classifier("json:CLASSIFIER", folder)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("toy_missing:NETWORK", r"'toy_missing:NETWORK'.*No module named 'toy_missing'.*\bname\b"),
        ("toy_networks:MISSING", r"'toy_networks:MISSING'.*no attribute 'MISSING'.*\bname\b"),
        ("toy_networks:inner.missing", r"no attribute 'missing'"),
        ("toy_needs:NETWORK", r"'a_package_that_is_missing'.*\binstall\b"),
        ("toy_broken:NETWORK", r"\bSyntaxError\b.*\bcorrect\b"),
        ("toy_networks:fail", r"\bRuntimeError: no such weights\b"),
        ("toy_networks:Needy", r"\bTypeError\b.*\bwithout arguments\b"),
        ("toy_networks:NUMBER", r"'toy_networks:NUMBER' is 7\b.*`classes`.*`probabilities`"),
        ("toy_networks:UNNAMED", r"\bclasses \[\].*\bname\b"),
        ("toy_networks:TWICE", r"\bclasses \['a', 'a'\].*\btwice\b"),
        ("toy_networks:TEXT", r"\bclasses 'ab'"),
        ("missing.npz", r"\bmissing\.npz\b.*No such file"),
        ("C:missing.npz", r"\bC:missing\.npz\b.*No such file"),
        ("missing", r"\bmissing\b.*No such file"),
    ],
)
def test_what_is_no_classifier_is_refused(folder: Path, name: str, said: str) -> None:
    with pytest.raises(DatabaseError, match=said):
        load_classifier(name, folder)


def test_a_file_is_a_database_whatever_its_name(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("bulbs.npz", "toy_networks:NETWORK"):
        database().save(folder / name)
        loaded = load_classifier(name, folder)
        assert isinstance(loaded, NearestNeighbour)
        assert loaded.classes == tuple(CLASSES)
    monkeypatch.chdir(folder)
    assert load_classifier("bulbs.npz").classes == tuple(CLASSES)


def test_an_installed_classifier(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("acme", "toy_networks:NETWORK", "beltsort.classifier")
    installed = {"beltsort.classifier": [entry]}
    monkeypatch.setattr(named_classifier, "entry_points", lambda group: installed.get(group, []))
    monkeypatch.syspath_prepend(folder)
    assert load_classifier("acme").classes == ("a", "b")
    database().save(folder / "acme")
    assert load_classifier("acme", folder).classes == tuple(CLASSES), "a file of this name"


def test_a_match_without_a_score_for_every_class_is_refused() -> None:
    class Short:
        classes = ("a", "b", "c")

        def classify(self, points: Points, camera: Points) -> Match:
            return Match(1, np.ones(2))

    layout = BeltLayout()
    scene = Scene(layout, np.random.default_rng(3))
    scan = scene.scan(scene.belt(), scene.ellipsoid(0, (0.03, 0.03, 0.02)))
    with pytest.raises(DatabaseError, match=r"\b2 classes\b.*\['a', 'b', 'c'\]"):
        Perception(layout, Short())(scan)
