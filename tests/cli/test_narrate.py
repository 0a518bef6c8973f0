"""A scan in words: labels, and why there is none."""

from beltsort.cli.narrate import Narrator
from beltsort.models import paper
from beltsort.perception import Finding
from beltsort.sorting.entries import Scanned, Started
from beltsort.sorting.journal import Entry


def test_a_scan_tells_labels_and_findings() -> None:
    model, narrator = paper(), Narrator()
    narrator.line(Entry(1, "", None, Started(run="a", objects=2, model=model.to_json())))

    def told(labels: list[int | None], findings: list[Finding]) -> str:
        belief = [model.arrival.tolist()] * 2
        scan = Scanned(0, labels, [False, False], [*findings], [], belief, [[-1] * 3] * 2)
        line = narrator.line(Entry(2, "", 0, scan))
        assert line is not None
        return line

    first, second, *_ = model.classes
    assert f"{first} | {second}  ->" in told([0, 1], [Finding.OBJECT, Finding.OBJECT])
    assert "? | empty  ->" in told([None, None], [Finding.OBJECT, Finding.EMPTY])
    assert "hidden | several objects  ->" in told([None, None], [Finding.HIDDEN, Finding.SEVERAL])
