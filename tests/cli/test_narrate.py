"""A scan in words: labels, and why there is none."""

from beltsort.cli.narrate import Narrator
from beltsort.journal import Entry
from beltsort.models import paper
from beltsort.perception import Outcome


def test_a_scan_tells_labels_and_outcomes() -> None:
    model, narrator = paper(), Narrator()
    narrator.line(Entry(1, "", "start", None, {"objects": 2, "model": model.to_json()}))

    def told(labels: list[int | None], outcomes: list[Outcome]) -> str:
        belief = [model.arrival.tolist()] * 2
        data = {"viewpoint": 0, "labels": labels, "outcomes": outcomes, "belief": belief}
        line = narrator.line(Entry(2, "", "scan", 0, data))
        assert line is not None
        return line

    first, second, *_ = model.classes
    assert f"{first} | {second}  ->" in told([0, 1], [Outcome.OBJECT, Outcome.OBJECT])
    assert "? | empty  ->" in told([None, None], [Outcome.OBJECT, Outcome.EMPTY])
    assert "hidden | several objects  ->" in told([None, None], [Outcome.HIDDEN, Outcome.SEVERAL])
