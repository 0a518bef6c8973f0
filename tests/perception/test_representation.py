"""What a REPL and a notebook show of classifiers, confusion tables, rules and scans: names, and no arrays."""

import numpy as np

from beltsort.cell import Scan
from beltsort.geometry import BeltLayout
from beltsort.perception import (
    KernelRidge,
    LabelRule,
    Match,
    NearestNeighbour,
    Perceived,
    Perception,
    Segmented,
    confusion,
)
from beltsort.perception.finding import Finding

ROWS = np.repeat(np.eye(2, 308), 3, axis=0)
DATABASE = NearestNeighbour.train(ROWS, [0, 0, 0, 1, 1, 1], ["bulb & co", "cup"], k=3, reject=0.5)
CONFUSION = confusion([0, 0, 1], [Match(label, np.ones(2)) for label in (0, 1, 1)], DATABASE.classes)


def test_classifiers_show_their_classes_and_settings() -> None:
    entries = "entries 6 (bulb & co 3, cup 3), descriptor vfh, distance chi2, reject 0.5"
    assert repr(DATABASE) == f"NearestNeighbour({entries}, k 3)"
    ridge = KernelRidge.train(DATABASE)
    assert repr(ridge).startswith(f"KernelRidge({entries}, scale ")
    for classifier in (DATABASE, ridge):
        assert "bulb &amp; co 3, cup 3" in classifier._repr_html_()
    assert repr(Perception(BeltLayout(), DATABASE)).endswith(", positions 2, labels bulb & co, cup)")


def test_confusion_is_a_table() -> None:
    assert repr(CONFUSION) == f"Confusion: 2 of 3 right\n{CONFUSION}"
    assert CONFUSION._repr_html_().count("<tr") == 3
    assert "bulb &amp; co" in CONFUSION._repr_html_()


def test_a_rule_prints_its_labels_and_its_repr_makes_it_again() -> None:
    rule = LabelRule(("nut", "bolt"), edges=(0.25,), not_recognised=True)
    assert eval(repr(rule)) == rule
    title, *labels = str(rule).splitlines()
    assert title == "LabelRule: 2 levels of confidence, margin cut at 0.25"
    assert [label.strip() for label in labels] == list(rule.labels)
    assert "nut, unsure" in rule._repr_html_()
    assert str(LabelRule(("nut", "bolt"))).startswith("LabelRule: labels without levels")


def test_scans_and_what_they_show_give_shapes() -> None:
    points = np.zeros((480, 640, 3))
    assert repr(Scan(points, np.eye(4), 2.0)) == (
        "Scan(480 x 640 points, camera 'camera' at (0.000, 0.000, 0.000) m, stamp 2.000 s)"
    )
    candidate = points.reshape(-1, 3)
    seen = Perceived(0, candidate, 1, Match(1, np.array([0.25, 0.75])))
    assert "points=<shape (307200, 3)>, label=1, match=Match(label=1, scores=[0.25, 0.75]," in repr(seen)
    segmented = Segmented((candidate, None), (Finding.OBJECT, Finding.EMPTY), np.array([0.0, 0.5, 1.0]))
    assert repr(segmented).startswith("Segmented(candidates=(<shape (307200, 3)>, None), findings=(")
    assert "camera=[0, 0.5, 1]" in repr(segmented)
