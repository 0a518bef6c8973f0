"""Entries in words."""

from beltsort.cell import MoveTo, SortInto
from beltsort.models import paper
from beltsort.perception import Finding
from beltsort.sorting.command import Command
from beltsort.sorting.entries import Intended, Scanned, Started
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry


def test_a_scan_tells_labels_and_findings() -> None:
    model, formatter = paper(), EntryFormatter()
    formatter.format(Entry(1, "", None, Started(run="a", objects=2, model=model.to_json())))

    def told(labels: list[int | None], findings: list[Finding]) -> str:
        belief = [model.arrival.tolist()] * 2
        scan = Scanned(0, labels, [False, False], [*findings], [], belief, [[-1] * 3] * 2)
        line = formatter.format(Entry(2, "", 0, scan))
        assert line is not None
        return line

    first, second, *_ = model.classes
    assert f"{first} | {second}  ->" in told([0, 1], [Finding.OBJECT, Finding.OBJECT])
    assert "? | empty  ->" in told([None, None], [Finding.OBJECT, Finding.EMPTY])
    assert "hidden | several objects  ->" in told([None, None], [Finding.HIDDEN, Finding.SEVERAL])


def test_a_fault_of_the_pose_is_told_once_a_kind() -> None:
    model, formatter = paper(), EntryFormatter()
    formatter.format(Entry(1, "", None, Started(run="a", objects=2, model=model.to_json())))
    belief = [model.arrival.tolist()] * 2

    def told(fault: str | None) -> str:
        findings = [Finding.HIDDEN, Finding.HIDDEN]
        scan = Scanned(
            0, [None, None], [False, False], [*findings], [], belief, [[-1] * 3] * 2, pose_fault=fault
        )
        return formatter.format(Entry(2, "", 0, scan)) or ""

    assert "warning" not in told(None)
    assert "warning" in told("the pose is inverted")
    assert "warning" not in told("the pose is inverted")
    assert "in millimetres" in told("the pose is in millimetres")


def test_a_sort_tells_the_bin_by_name_and_number() -> None:
    formatter, sort = EntryFormatter(), Command("a-sort-1", SortInto(1), "boot")
    line = formatter.format(Entry(1, "", 7, Intended(sort, "livarno", 3)))
    assert line == 'object  7  into bin "livarno" (3)'
    again = formatter.format(Entry(2, "", 7, Intended(sort.again("boot"), "livarno", 3)))
    assert again == f"{line}, attempt 2"
    assert formatter.format(Entry(3, "", 7, Intended(sort))) is None, "an older version did not tell the bin"
    assert formatter.format(Entry(4, "", 7, Intended(Command("a-move-2", MoveTo(1), "boot")))) is None
